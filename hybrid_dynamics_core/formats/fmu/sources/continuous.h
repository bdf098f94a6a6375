/* Model exchange, the same in all versions of FMI: `DERIVATIVES` is the name of one function. */

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
