/* The unit "inverse_dynamics": motion in, efforts out. Included once, by the functions of FMI. */
#define N_STATES 0

static int is_state(unsigned k)
{
    (void)k;
    return 0;
}

/* Compute what depends on inputs. */
static int compute(unit_data *unit, int what)
{
    double *v = unit->value;
    double guess[NS], tau[NU];
    const double *u = v + V_U, *du = v + V_DU, *ddu = v + V_DDU;
    int status;
    (void)what;
    memcpy(guess, unit->guess, sizeof guess);
    status = follow(guess, u);
    if (status == UNIT_OK) {
        status = unit_inverse_dynamics(u, du, ddu, v + V_GRAVITY, LOADS(v) guess, tau);
    }
    if (status == UNIT_OK) {
        memcpy(v + V_TAU, tau, sizeof tau);
    }
    return status;
}

/* Changes of the efforts for seeds, changes of inputs: both by value reference. */
static int change_along(const unit_data *unit, const double seed[V_COUNT], double change[V_COUNT])
{
    const double *v = unit->value;
    double guess[NS];
    int status;
    memcpy(guess, unit->guess, sizeof guess);
    status = follow(guess, v + V_U);
    if (status == UNIT_OK) {
        status = unit_directional(v + V_U, v + V_DU, v + V_DDU, v + V_GRAVITY, seed + V_U,
                                  seed + V_DU, seed + V_DDU, LOADS(v) guess, change + V_TAU);
    }
    return status;
}

static int what_of(unsigned k)
{
    return k >= V_TAU ? DYNAMICS : NOTHING;
}

/* Nothing is integrated: the configuration is that of the inputs. */
static int advance(unit_data *unit, double length, double *passed)
{
    *passed = length;
    unit->limit = N_LIMITS;
    return follow(unit->guess, unit->value + V_U);
}
