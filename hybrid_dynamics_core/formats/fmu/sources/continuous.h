/* Model exchange, the same in all versions of FMI: `DERIVATIVES` is the name of one function. */

/* Changes of unknowns for changes of knowns, which are states and inputs. */
static status_t directional(instance_t *self, const reference_t unknowns[], size_t n,
                            const reference_t knowns[], size_t m, const double seed[],
                            double sensitivity[])
{
    double seeds[V_COUNT] = {0.0}, changes[V_COUNT];
    int status;
    for (size_t k = 0; k < n; ++k) {
        if (unknowns[k] >= V_COUNT) {
            return say(self, ERROR, "there is no such value reference");
        }
    }
    for (size_t k = 0; k < m; ++k) {
        if (!is_varied(knowns[k])) {
            return say(self, ERROR, "a derivative by a value that is neither a state nor an input");
        }
        seeds[knowns[k]] = seed[k];
    }
    memcpy(changes, seeds, sizeof seeds);
    status = change_along(&self->data, seeds, changes);
    if (status == UNIT_OK) {
        for (size_t k = 0; k < n; ++k) {
            sensitivity[k] = changes[unknowns[k]];
        }
    }
    return answer(self, status);
}

FMI(SetTime)(void *c, double time)
{
    ((instance_t *)c)->data.value[V_TIME] = time;
    return OK;
}

#if N_STATES > 0
FMI(SetContinuousStates)(void *c, const double states[], size_t n)
{
    instance_t *self = c;
    if (n != N_STATES) {
        return say(self, ERROR, "another number of states");
    }
    memcpy(self->data.value + V_U, states, N_STATES * sizeof *states);
    self->data.fresh = 0;
    return OK;
}

DERIVATIVES(void *c, double derivatives[], size_t n)
{
    instance_t *self = c;
    int status;
    if (n != N_STATES) {
        return say(self, ERROR, "another number of states");
    }
    status = refresh(&self->data, DYNAMICS);
    if (status == UNIT_OK) {
        memcpy(derivatives, self->data.value + V_DER_U, N_STATES * sizeof *derivatives);
    }
    return answer(self, status);
}

FMI(GetContinuousStates)(void *c, double states[], size_t n)
{
    instance_t *self = c;
    if (n != N_STATES) {
        return say(self, ERROR, "another number of states");
    }
    memcpy(states, self->data.value + V_U, N_STATES * sizeof *states);
    return OK;
}
#else
FMI(SetContinuousStates)(void *c, const double states[], size_t n)
{
    (void)states;
    return n == 0 ? OK : not_here(c);
}

DERIVATIVES(void *c, double derivatives[], size_t n)
{
    (void)derivatives;
    return n == 0 ? OK : not_here(c);
}

FMI(GetContinuousStates)(void *c, double states[], size_t n)
{
    (void)states;
    return n == 0 ? OK : not_here(c);
}
#endif

FMI(GetEventIndicators)(void *c, double indicators[], size_t n)
{
    instance_t *self = c;
    int status;
    if (n != N_LIMITS) {
        return say(self, ERROR, "another number of event indicators");
    }
    status = refresh(&self->data, KINEMATICS);
    if (status == UNIT_OK) {
        memcpy(indicators, self->data.value + V_DISTANCE, n * sizeof *indicators);
    }
    return answer(self, status);
}

FMI(GetNominalsOfContinuousStates)(void *c, double nominals[], size_t n)
{
    (void)c;
    for (size_t k = 0; k < n; ++k) {
        nominals[k] = 1.0;
    }
    return OK;
}
