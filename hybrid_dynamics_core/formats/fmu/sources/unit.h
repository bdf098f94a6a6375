/* What both versions of FMI share: the values of a unit, and how loops are followed.

   A unit keeps its variables in one array; a value reference is an index. It computes nothing
   before it is asked, and keeps the configuration of the last accepted state as a guess. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "unit_model.h"

#define PIECES 4096           /* most calls that follow a move */
#define NEAR_LIMIT 1e-9       /* [rad or m] */
#define SHORTEST (1.0 / 1024) /* shortest piece of a move */

enum { NOTHING = 0, KINEMATICS = 1, DYNAMICS = 2 };
enum { UNIT_TOO_MANY_STEPS = 100 }; /* after the statuses of the model */

typedef struct {
    double value[V_COUNT];
    double guess[NS];
    double tolerance;
    double step; /* of the integration, proposed [s] */
    int fresh;   /* kinds of values that are computed */
    int initialised;
    int stops;   /* whether a motion ends at a limit */
    int limit;   /* that it met; N_LIMITS if none */
} unit_data;

/* Close the loops at u from a guess, in pieces that no loop jumps in; the guess is replaced. */
static int follow(double guess[NS], const double *u)
{
    const double still[NU] = {0.0};
    double from[NU], at[NU], s[NS], ds[NS];
    double done = 0.0, piece = 1.0;
    memcpy(from, guess, sizeof from);
    for (int calls = 0; calls < PIECES; ++calls) {
        const int last = done + piece >= 1.0;
        int status;
        for (int k = 0; k < NU; ++k) {
            at[k] = last ? u[k] : from[k] + (done + piece) * (u[k] - from[k]);
        }
        status = unit_close(at, still, guess, s, ds);
        if (status == UNIT_OK && last) {
            return UNIT_OK;
        }
        if (status == UNIT_OK) {
            done += piece;
            piece *= 2.0;
        } else if (!FOLLOWS || piece <= SHORTEST) {
            return status;
        } else {
            piece *= 0.5;
        }
    }
    return UNIT_JUMP;
}

/* Distance of a configuration to a limit, negative beyond it. */
static double limit_distance(int k, const double configuration[NS])
{
    const unit_limit limit = unit_limits[k];
    return limit.side * (limit.value - configuration[limit.index]);
}

#include "unit_kind.h"

static const char *message_of(int status)
{
    if (status == UNIT_TOO_MANY_STEPS) {
        return "the integration needs too small steps: the motion is near a singular place, or stiff";
    }
    return unit_status_text(status);
}

static void reset(unit_data *unit)
{
    memset(unit, 0, sizeof *unit);
    memcpy(unit->value, unit_starts, sizeof unit_starts);
    memcpy(unit->guess, unit_reference, sizeof unit->guess);
    unit->tolerance = 1e-9;
    unit->step = 1e-3;
    unit->stops = 1;
    unit->limit = N_LIMITS;
}

/* Values of a kind, computed where they are not. */
static int refresh(unit_data *unit, int what)
{
    int status = UNIT_OK;
    if (what != NOTHING && !(unit->fresh & what)) {
        status = compute(unit, what);
        if (status == UNIT_OK) {
            unit->fresh |= what;
        }
    }
    return status;
}

static int is_input(unsigned k)
{
    return k >= V_INPUTS && k < V_INPUTS_END;
}

/* Whether there are derivatives by a value. */
static int is_varied(unsigned k)
{
    return is_input(k) || is_state(k);
}

/* Whether a value may be set: inputs at any time, parameters and states before the start. */
static int is_settable(const unit_data *unit, unsigned k)
{
    if (is_input(k)) {
        return 1;
    }
    return !unit->initialised && ((k >= V_GRAVITY && k < V_INPUTS) || is_state(k));
}

/* Accept the present state: what comes next is followed from it. */
static int accept(unit_data *unit)
{
    return follow(unit->guess, unit->value + V_U);
}

/* The limit that the present state is beyond or, with `at`, moves into; N_LIMITS if none. */
static int limit_of(unit_data *unit, int at)
{
    double guess[NS], s[NS], ds[NS];
    memcpy(guess, unit->guess, sizeof guess);
    if (!unit->stops || follow(guess, unit->value + V_U) != UNIT_OK
        || unit_close(unit->value + V_U, unit->value + V_DU, guess, s, ds) != UNIT_OK) {
        return N_LIMITS;
    }
    for (int k = 0; k < N_LIMITS; ++k) {
        const double distance = limit_distance(k, s);
        const double speed = unit_limits[k].side * ds[unit_limits[k].index];
        if (distance < 0.0 || (at && distance < NEAR_LIMIT && speed > 0.0)) {
            return k;
        }
    }
    return N_LIMITS;
}
