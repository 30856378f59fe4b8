/* One bare wheel, explicit tracking, regularized friction, classic Runge-Kutta: the peer of the compiled kernels.
 *
 * Written from the equations alone, as a C programmer would: constants in one struct, every helper inlined, the
 * state a plain array of twelve. It does what the package does for such a scene and nothing else: the motion, the
 * three energy integrals, roller exchanges located to rounding, one row of output every `steps_per_row` steps with the
 * extremes since the last one. No tables, no tracking to choose, no events but exchanges, no checks.
 */
#include <math.h>
#include <stddef.h>

enum { FRICTION_SQUARE, SLIP_SQUARE, LEAST_POWER, MOST_POWER, EXTREMES };
enum { X, Y, YAW, V_X, V_Y, YAW_RATE, FRICTION_LOSS, DRIVE_WORK, WRENCH_WORK, SPIN_ANGLE, SPIN_RATE, ROLLER_RATE, STATES };

typedef struct {
    double mobility, yaw_mobility, slip_speed;      /* 1 / M, 1 / I_z, eps */
    double radius, roller_distance;                 /* R, R1 */
    double spin_mobility, axial_mobility;           /* 1 / J_k, 1 / Ia */
    double cos_psi, sin_psi, tan_psi;
    double alpha, phase;                            /* half a roller's sector, azimuth of roller 0 */
    double axial_inertia;                           /* Ia */
    double friction_limit, torque;                  /* mu N, and what is constant of drive and wrench */
    double force_x, force_y, yaw_torque;            /* in world axes */
    long rollers;
} Wheel;

typedef struct {
    long roller;              /* in contact, counted on through every turn */
    double air_cos, air_sin;  /* sums of p_i cos D_i and p_i sin D_i over the rollers in the air */
} Mode;

/* what is followed of a state: squares of friction and slip, drive power; the load and the drive torque are constant */
typedef struct {
    double friction_square, slip_square, power;
} Contact;

/* dy, and the Contact unless it is NULL */
static inline void rhs(const Wheel *w, const Mode *mode, const double *y, double *dy, Contact *contact)
{
    double cos_yaw = cos(y[YAW]), sin_yaw = sin(y[YAW]);
    double q = w->phase + 2.0 * w->alpha * mode->roller - y[SPIN_ANGLE];
    double cos_q = cos(q), sin_q = sin(q);
    double axis_h = -w->cos_psi * cos_q, axis_n = -w->cos_psi * sin_q;

    double at_centre = w->roller_distance / cos_q;
    double h_q = w->radius - at_centre;
    double l = at_centre * sin_q * w->tan_psi;
    double arm_h = -h_q * w->sin_psi, arm_k = h_q * axis_h;

    double joint = y[ROLLER_RATE] - y[SPIN_RATE] * w->sin_psi - y[YAW_RATE] * axis_n;
    double slip_h = y[V_X] * cos_yaw + y[V_Y] * sin_yaw - y[SPIN_RATE] * w->radius - y[YAW_RATE] * l + joint * arm_h;
    double slip_k = y[V_Y] * cos_yaw - y[V_X] * sin_yaw + joint * arm_k;

    double slip_square = slip_h * slip_h + slip_k * slip_k;
    double factor = w->friction_limit / sqrt(slip_square + w->slip_speed * w->slip_speed);
    double force_h = -factor * slip_h, force_k = -factor * slip_k;
    double roller_torque = arm_h * force_h + arm_k * force_k;
    double g_h = -w->cos_psi * w->axial_inertia * (cos_q * (mode->air_cos + y[ROLLER_RATE]) - sin_q * mode->air_sin);

    dy[X] = y[V_X];
    dy[Y] = y[V_Y];
    dy[YAW] = y[YAW_RATE];
    dy[V_X] = (w->force_x + force_h * cos_yaw - force_k * sin_yaw) * w->mobility;
    dy[V_Y] = (w->force_y + force_h * sin_yaw + force_k * cos_yaw) * w->mobility;
    dy[YAW_RATE] = (w->yaw_torque + y[SPIN_RATE] * g_h - roller_torque * axis_n - l * force_h) * w->yaw_mobility;
    dy[FRICTION_LOSS] = -(force_h * slip_h + force_k * slip_k);
    dy[DRIVE_WORK] = w->torque * y[SPIN_RATE];
    dy[WRENCH_WORK] = w->force_x * y[V_X] + w->force_y * y[V_Y] + w->yaw_torque * y[YAW_RATE];
    dy[SPIN_ANGLE] = y[SPIN_RATE];
    dy[SPIN_RATE] = (w->torque - w->radius * force_h - roller_torque * w->sin_psi - y[YAW_RATE] * g_h) * w->spin_mobility;
    dy[ROLLER_RATE] = roller_torque * w->axial_mobility;
    if (contact) *contact = (Contact){force_h * force_h + force_k * force_k, slip_square, dy[DRIVE_WORK]};
}

/* out = the state after a step of length h from y, whose derivative is k1 */
static void step(const Wheel *w, const Mode *mode, const double *y, const double *k1, double h, double *out)
{
    double k2[STATES], k3[STATES], k4[STATES], stage[STATES];
    for (int i = 0; i < STATES; i++) stage[i] = y[i] + 0.5 * h * k1[i];
    rhs(w, mode, stage, k2, NULL);
    for (int i = 0; i < STATES; i++) stage[i] = y[i] + 0.5 * h * k2[i];
    rhs(w, mode, stage, k3, NULL);
    for (int i = 0; i < STATES; i++) stage[i] = y[i] + h * k3[i];
    rhs(w, mode, stage, k4, NULL);
    for (int i = 0; i < STATES; i++) out[i] = y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
}

/* how far the spin angle still is from the end of the roller ahead: negative when that roller is left */
static inline double to_end(const Wheel *w, const Mode *mode, const double *y, int direction)
{
    return direction * (w->phase + w->alpha * (2 * mode->roller + direction) - y[SPIN_ANGLE]);
}

/* put a roller into contact: its rate enters the state, the sums of the others are taken anew */
static void take(const Wheel *w, Mode *mode, double *y, const double *rates, long roller)
{
    long here = (roller % w->rollers + w->rollers) % w->rollers;
    mode->roller = roller;
    mode->air_cos = mode->air_sin = 0.0;
    for (long i = 0; i < w->rollers; i++) {
        if (i == here) continue;
        mode->air_cos += rates[i] * cos(2.0 * w->alpha * (i - here));
        mode->air_sin += rates[i] * sin(2.0 * w->alpha * (i - here));
    }
    y[ROLLER_RATE] = rates[here];
}

static void release(const Wheel *w, const Mode *mode, const double *y, double *rates)
{
    rates[(mode->roller % w->rollers + w->rollers) % w->rollers] = y[ROLLER_RATE];
}

static inline void begin_interval(double *extremes, const Contact *contact)
{
    extremes[FRICTION_SQUARE] = contact->friction_square, extremes[SLIP_SQUARE] = contact->slip_square;
    extremes[LEAST_POWER] = extremes[MOST_POWER] = contact->power;
}

static inline void follow(double *extremes, const Contact *contact)
{
    if (contact->friction_square > extremes[FRICTION_SQUARE]) extremes[FRICTION_SQUARE] = contact->friction_square;
    if (contact->slip_square > extremes[SLIP_SQUARE]) extremes[SLIP_SQUARE] = contact->slip_square;
    if (contact->power < extremes[LEAST_POWER]) extremes[LEAST_POWER] = contact->power;
    if (contact->power > extremes[MOST_POWER]) extremes[MOST_POWER] = contact->power;
}

/* March `steps` steps; y (12) and rates (N_r) go in and out, rows (steps / steps_per_row, 12) and the extremes of the
 * interval that each ends (steps / steps_per_row, EXTREMES). Returns the exchanges. */
long march(const Wheel *w, double *y, double *rates, double dt, long steps, long steps_per_row, double *rows, double *extremes)
{
    Mode mode;
    Contact contact;
    long exchanges = 0;
    double k1[STATES], interval[EXTREMES];
    take(w, &mode, y, rates, lround((y[SPIN_ANGLE] - w->phase) / (2.0 * w->alpha)));
    rhs(w, &mode, y, k1, &contact);
    begin_interval(interval, &contact);
    for (long n = 1; n <= steps; n++) {
        double rest = dt;
        for (;;) {
            double trial[STATES], h = rest;
            step(w, &mode, y, k1, h, trial);
            int direction = trial[SPIN_RATE] < 0.0 ? -1 : 1;
            int leaves = to_end(w, &mode, trial, direction) < 0.0;
            if (leaves) { /* Newton: the spin rate is the derivative of the spin angle */
                for (int i = 0; i < 20; i++) {
                    double correction = to_end(w, &mode, trial, direction) / (direction * trial[SPIN_RATE]);
                    h += correction;
                    step(w, &mode, y, k1, h, trial);
                    if (fabs(correction) < 1e-12 * dt + 1e-15 * n * dt) break;
                }
            }
            for (int i = 0; i < STATES; i++) y[i] = trial[i];
            rhs(w, &mode, y, k1, &contact);
            follow(interval, &contact);
            if (!leaves) break;
            rest -= h;
            exchanges++;
            release(w, &mode, y, rates);
            take(w, &mode, y, rates, mode.roller + direction);
            rhs(w, &mode, y, k1, &contact);
            follow(interval, &contact);
        }
        if (n % steps_per_row == 0) {
            long row = n / steps_per_row - 1;
            for (int i = 0; i < STATES; i++) rows[row * STATES + i] = y[i];
            for (int i = 0; i < EXTREMES; i++) extremes[row * EXTREMES + i] = interval[i];
            begin_interval(interval, &contact);
        }
    }
    release(w, &mode, y, rates);
    return exchanges;
}
