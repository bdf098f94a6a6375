/* The unit "forward_dynamics": efforts in, motion out. Included once, by the functions of FMI. */
#define N_STATES (2 * NU)
#define STEPS 100000   /* most steps of integration in one call */
#define HALVINGS 40    /* of one step */
#define INSTANT 1e-10  /* [s] a limit is met within */
#define LONGEST 1.0    /* [rad or m] longest move of a coordinate in one step: turns are counted */

static int is_state(unsigned k)
{
    return k >= V_U && k < V_U + N_STATES;
}

/* Accelerations at a state y = (u, u'); the guess becomes the configuration. */
static int accelerations(const double *v, const double *y, double guess[NS], double ddu[NU])
{
    const double *tau = v + V_TAU, *gravity = v + V_GRAVITY;
    int status = unit_forward_dynamics(y, y + NU, tau, gravity, LOADS(v) guess, ddu);
    if (status != UNIT_OK && FOLLOWS) {
        status = follow(guess, y);
        if (status == UNIT_OK) {
            status = unit_forward_dynamics(y, y + NU, tau, gravity, LOADS(v) guess, ddu);
        }
    }
    return status;
}

/* Slopes dy of a state y, from the last accepted configuration. */
static int slopes(const unit_data *unit, const double *y, double *dy, double configuration[NS])
{
    int status;
    memcpy(configuration, unit->guess, sizeof unit->guess);
    status = accelerations(unit->value, y, configuration, dy + NU);
    if (status == UNIT_OK) {
        memcpy(dy, y + NU, NU * sizeof *dy);
    }
    return status;
}

/* Compute what depends on inputs and states. */
static int compute(unit_data *unit, int what)
{
    double *v = unit->value;
    const double *u = v + V_U, *du = u + NU;
    int status = UNIT_OK;
    if (what == DYNAMICS) {
        double dy[N_STATES], configuration[NS];
        status = slopes(unit, u, dy, configuration);
        if (status == UNIT_OK) {
            memcpy(v + V_DER_U, dy, sizeof dy);
        }
        return status;
    }
    {
        double guess[NS], s[NS], ds[NS], place[3], turn[9];
        double *distances = v + V_DISTANCE;
        memcpy(guess, unit->guess, sizeof guess);
        status = follow(guess, u);
        if (status == UNIT_OK) {
            status = unit_close(u, du, guess, s, ds);
        }
        if (status == UNIT_OK) {
            status = unit_forward_kinematics(u, guess, place, turn);
        }
        if (status == UNIT_OK) {
            memcpy(v + V_Z, s + NU, (NS - NU) * sizeof *s);
            memcpy(v + V_DZ, ds + NU, (NS - NU) * sizeof *ds);
            memcpy(v + V_POSITION, place, sizeof place);
            memcpy(v + V_ROTATION, turn, sizeof turn);
            for (int k = 0; k < N_LIMITS; ++k) {
                distances[k] = limit_distance(k, s);
            }
        }
    }
    return status;
}

/* Changes of all values for seeds, changes of states and inputs: both by value reference. */
static int change_along(const unit_data *unit, const double seed[V_COUNT], double change[V_COUNT])
{
    const double *v = unit->value;
    const double *u = v + V_U, *du = u + NU, *tau = v + V_TAU;
    double guess[NS], d_s[NS], d_ds[NS];
    int status;
    memcpy(guess, unit->guess, sizeof guess);
    status = follow(guess, u);
    if (status == UNIT_OK) {
        status = unit_directional(u, du, tau, v + V_GRAVITY, seed + V_U, seed + V_U + NU,
                                  seed + V_TAU, LOADS(v) guess, change + V_DER_U + NU, d_s, d_ds,
                                  change + V_POSITION, change + V_ROTATION);
    }
    if (status == UNIT_OK) {
        double *distances = change + V_DISTANCE;
        memcpy(change + V_DER_U, seed + V_U + NU, NU * sizeof *change);
        memcpy(change + V_Z, d_s + NU, (NS - NU) * sizeof *d_s);
        memcpy(change + V_DZ, d_ds + NU, (NS - NU) * sizeof *d_ds);
        for (int k = 0; k < N_LIMITS; ++k) {
            distances[k] = -unit_limits[k].side * d_s[unit_limits[k].index];
        }
    }
    return status;
}

static int what_of(unsigned k)
{
    if (k >= V_DER_U && k < V_DER_U + N_STATES) {
        return DYNAMICS;
    }
    return k >= V_Z ? KINEMATICS : NOTHING;
}

/* Dormand and Prince (1980), 5th order, with an error of 4th order. */
static const double A[6][6] = {
    {1.0 / 5.0},
    {3.0 / 40.0, 9.0 / 40.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
static const double E[7] = {71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0,
                            -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};

/* One step of length h from y, whose slope is k[0]; the slope after it is k[6]. */
static int try_step(const unit_data *unit, const double *y, double h, double k[7][N_STATES],
                    double *after, double configuration[NS], double *error)
{
    double square = 0.0;
    for (int stage = 0; stage < 6; ++stage) {
        int status;
        for (int j = 0; j < N_STATES; ++j) {
            double slope = 0.0;
            for (int i = 0; i <= stage; ++i) {
                slope += A[stage][i] * k[i][j];
            }
            after[j] = y[j] + h * slope;
        }
        status = slopes(unit, after, k[stage + 1], configuration);
        if (status != UNIT_OK) {
            return status;
        }
    }
    for (int j = 0; j < N_STATES; ++j) {
        const double size = fmax(fabs(y[j]), fabs(after[j]));
        double difference = 0.0;
        for (int i = 0; i < 7; ++i) {
            difference += E[i] * k[i][j];
        }
        difference *= h / (unit->tolerance * (0.01 + size));
        square += difference * difference;
    }
    *error = sqrt(square / N_STATES);
    for (int j = 0; j < NS; ++j) {
        if (fabs(configuration[j] - unit->guess[j]) > LONGEST) {
            return UNIT_JUMP;
        }
    }
    return isfinite(*error) ? UNIT_OK : UNIT_NOT_FINITE;
}

/* The limit that a configuration is beyond; N_LIMITS if none. */
static int limit_beyond(const double configuration[NS])
{
    int k = 0;
    while (k < N_LIMITS && limit_distance(k, configuration) >= 0.0) {
        ++k;
    }
    return k;
}

/* Integrate over a time; `passed` says how far it came. It ends before a limit. */
static int advance(unit_data *unit, double length, double *passed)
{
    double k[7][N_STATES], after[N_STATES], configuration[NS];
    double *y = unit->value + V_U;
    int status = slopes(unit, y, k[0], configuration), halved = 0, crossing = 0;
    *passed = 0.0;
    unit->limit = N_LIMITS;
    for (int step = 0; status == UNIT_OK && *passed < length; ++step) {
        const double remaining = length - *passed;
        const int last = unit->step >= remaining;
        const double h = last ? remaining : unit->step;
        double error = 0.0, factor = 0.5;
        if (step == STEPS) {
            return UNIT_TOO_MANY_STEPS;
        }
        status = try_step(unit, y, h, k, after, configuration, &error);
        if (status == UNIT_OK && error <= 1.0 && unit->stops
            && limit_beyond(configuration) < N_LIMITS) {
            crossing = 1;
            if (h < INSTANT) {
                unit->limit = limit_beyond(configuration);
                return UNIT_OK;
            }
            unit->step = 0.5 * h;
            continue;
        }
        if (status == UNIT_OK && error <= 1.0) {
            *passed = last ? length : *passed + h;
            memcpy(y, after, sizeof after);
            memcpy(unit->guess, configuration, sizeof configuration);
            memcpy(k[0], k[6], sizeof k[0]);
            halved = 0;
        } else if (++halved > HALVINGS) {
            return status == UNIT_OK ? UNIT_TOO_MANY_STEPS : status;
        }
        if (status == UNIT_OK) {
            factor = fmin(5.0, fmax(0.2, 0.9 * pow(fmax(error, 1e-10), -0.2)));
            if (halved || crossing) {
                factor = fmin(factor, 1.0);
            }
        }
        status = UNIT_OK;
        if (!last || factor < 1.0) {
            unit->step = h * factor;
        }
    }
    return status;
}
