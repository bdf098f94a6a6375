/* The exported forward dynamics of a robot under the classical Runge-Kutta method.

   ROBOT is the robot's name, given to the compiler. */

#define JOINED(a, b) a##b
#define NAMED(a, b) JOINED(a, b)
#define OF(name) NAMED(ROBOT, name)

enum { N = OF(_NU), M = OF(_NS) };

static int slope(const double *y, const double *tau, double *guess, double *rate)
{
    for (int i = 0; i < N; i++)
        rate[i] = y[N + i];
    return OF(_forward_dynamics)(y, y + N, tau, OF(_gravity), guess, rate + N);
}

/* rows (samples + 1, 2 N) of u and u', `inner` steps of h between two of them */
int run(const double *tau, int samples, int inner, double h, double *guess, double *rows)
{
    static const double share[4] = {0.0, 0.5, 0.5, 1.0};
    static const double weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    double y[2 * N], next[2 * N], at[2 * N], rate[2 * N] = {0};
    for (int i = 0; i < 2 * N; i++)
        y[i] = rows[i];
    for (int k = 1; k <= samples; k++) {
        for (int step = 0; step < inner; step++) {
            for (int i = 0; i < 2 * N; i++)
                next[i] = y[i];
            for (int stage = 0; stage < 4; stage++) {
                for (int i = 0; i < 2 * N; i++)
                    at[i] = y[i] + share[stage] * h * rate[i];
                int status = slope(at, tau, guess, rate);
                if (status)
                    return status;
                for (int i = 0; i < 2 * N; i++)
                    next[i] += weight[stage] * h * rate[i];
            }
            for (int i = 0; i < 2 * N; i++)
                y[i] = next[i];
        }
        for (int i = 0; i < 2 * N; i++)
            rows[2 * N * k + i] = y[i];
    }
    return 0;
}
