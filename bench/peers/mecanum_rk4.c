/* A machine on four parallel mecanum wheels, explicit tracking, regularized friction, classic Runge-Kutta: the peer of
 * the compiled kernels for a whole machine.
 *
 * Written from the equations alone, as a C programmer would, for such a machine and no other: all wheels head forward,
 * the four contacts carry roll and pitch, drives have a constant torque and nothing else acts. It does what the package
 * does for it: the motion, friction loss and drive work, the odometry of the ideal wheels, roller exchanges located to
 * rounding, one row of output every `steps_per_row` steps with the extremes since the last one. Sums are plain. No
 * events but exchanges, no checks.
 */
#include <math.h>
#include <stddef.h>

enum { WHEELS = 4 };
enum {
    X, Y, YAW, SPIN_ANGLE,
    V_X = SPIN_ANGLE + WHEELS, V_Y, YAW_RATE, SPIN_RATE,
    ROLLER_RATE = SPIN_RATE + WHEELS,
    FRICTION_LOSS = ROLLER_RATE + WHEELS, DRIVE_WORK, ODOMETRY_X, ODOMETRY_Y,
    STATES
};

/* extremes of each wheel, then of the odometry */
enum { FRICTION_SQUARE, SLIP_SQUARE, LEAST_LOAD, MOST_LOAD, LEAST_POWER, MOST_POWER, OF_WHEEL };
enum { POSITION_SQUARE = OF_WHEEL * WHEELS, LEAST_YAW, MOST_YAW, EXTREMES };

typedef struct {
    double radius, roller_distance;                 /* R, R1 */
    double spin_mobility, axial_mobility;           /* 1 / J_k, 1 / Ia */
    double cos_psi, sin_psi, tan_psi;
    double alpha, phase;                            /* half a roller's sector, azimuth of roller 0 */
    double axial_inertia, axle_inertia;             /* Ia, J_k */
    double ahead, aside;                            /* of the wheel centre from C, forward and left */
    double torque;
    double per_spin_x, per_spin_y, per_spin_yaw;    /* twist of the ideal machine by the spin rate */
} Wheel;

typedef struct {
    double mobility, yaw_mobility, slip_speed;      /* 1 / M, 1 / I_z, eps */
    double height, moment_x, moment_y;              /* z_C and S = sum m z e */
    double centre_x, centre_y;                      /* of C on the chassis */
    double weight, friction;                        /* M g, mu */
    double odometry_yaw;                            /* of the ideal machine at spin angles 0 */
    Wheel wheels[WHEELS];
    long rollers;                                   /* of each wheel */
} Machine;

typedef struct {
    long roller;                        /* in contact, counted on through every turn */
    double air_cos, air_sin, air_sum;   /* sums of p_i cos D_i, p_i sin D_i and p_i over the rollers in the air */
} Mode;

/* what a wheel has found at its contact until the loads are known: all but the place by newton of load */
typedef struct {
    double x, y;                        /* of the contact from C */
    double force_h, force_k, roller_torque, heat;
    double free_spin;                   /* torque on the spin without friction */
} Contact;

/* what is followed of a state: of each wheel squares of friction and slip, load and drive power; the odometry's error */
typedef struct {
    double friction_square[WHEELS], slip_square[WHEELS], load[WHEELS], power[WHEELS];
    double position_square, yaw;
} Followed;

/* dy, and what is followed unless it is NULL */
static inline void rhs(const Machine *m, const Mode *mode, const double *y, double *dy, Followed *followed)
{
    double cos_wheels[WHEELS], sin_wheels[WHEELS], odometry_yaw = m->odometry_yaw;
    for (int i = 0; i < WHEELS; i++) { /* all sines and cosines first: nothing waits for them one by one */
        const Wheel *w = &m->wheels[i];
        double q = w->phase + 2.0 * w->alpha * mode[i].roller - y[SPIN_ANGLE + i];
        cos_wheels[i] = cos(q), sin_wheels[i] = sin(q);
        odometry_yaw += w->per_spin_yaw * y[SPIN_ANGLE + i];
    }
    double cos_odometry = cos(odometry_yaw), sin_odometry = sin(odometry_yaw);
    double cos_yaw = cos(y[YAW]), sin_yaw = sin(y[YAW]), yaw_rate = y[YAW_RATE];
    double v_h = y[V_X] * cos_yaw + y[V_Y] * sin_yaw, v_k = y[V_Y] * cos_yaw - y[V_X] * sin_yaw;
    Contact contacts[WHEELS];
    double rim = m->slip_speed * m->slip_speed;
    double odometry_x = 0.0, odometry_y = 0.0;
    double power = 0.0, gyro_yaw = 0.0, gyro_heading = 0.0, torques = 0.0;
    double sum_x = 0.0, sum_y = 0.0;                                        /* of places */
    double f = 0.0, f_x = 0.0, f_y = 0.0, g = 0.0, g_x = 0.0, g_y = 0.0;    /* forces by load, load x and load y */
    double z = 0.0, z_x = 0.0, z_y = 0.0;                                   /* the same of the moment about n, */
    double a = 0.0, a_x = 0.0, a_y = 0.0, c = 0.0, c_x = 0.0, c_y = 0.0;    /* about k and about h */

    for (int i = 0; i < WHEELS; i++) {
        const Wheel *w = &m->wheels[i];
        double spin_rate = y[SPIN_RATE + i], roller_rate = y[ROLLER_RATE + i];
        double cos_q = cos_wheels[i], sin_q = sin_wheels[i];
        double axis_h = -w->cos_psi * cos_q, axis_n = -w->cos_psi * sin_q;

        double at_centre = w->roller_distance / cos_q;
        double h_q = w->radius - at_centre;
        double place_x = w->ahead, place_y = w->aside + at_centre * sin_q * w->tan_psi;
        double arm_h = -h_q * w->sin_psi, arm_k = h_q * axis_h;

        double joint = roller_rate - spin_rate * w->sin_psi - yaw_rate * axis_n;
        double slip_h = v_h - spin_rate * w->radius - yaw_rate * place_y + joint * arm_h;
        double slip_k = v_k + yaw_rate * place_x + joint * arm_k;

        double slip_square = slip_h * slip_h + slip_k * slip_k;
        double factor = m->friction / sqrt(slip_square + rim);
        double force_h = -factor * slip_h, force_k = -factor * slip_k;
        double roller_torque = arm_h * force_h + arm_k * force_k;

        double across = mode[i].air_cos + roller_rate, momentum = w->cos_psi * w->axial_inertia;
        double g_h = -momentum * (cos_q * across - sin_q * mode[i].air_sin);
        double g_n = -momentum * (sin_q * across + cos_q * mode[i].air_sin);
        double g_k = w->sin_psi * w->axial_inertia * (mode[i].air_sum + roller_rate);

        double about_n = place_x * force_k - place_y * force_h - roller_torque * axis_n;
        double about_k = place_x + (m->height - w->radius) * force_h;
        double about_h = place_y + m->height * force_k - roller_torque * axis_h;
        sum_x += place_x, sum_y += place_y;
        f += force_h, f_x += force_h * place_x, f_y += force_h * place_y;
        g += force_k, g_x += force_k * place_x, g_y += force_k * place_y;
        z += about_n, z_x += about_n * place_x, z_y += about_n * place_y;
        a += about_k, a_x += about_k * place_x, a_y += about_k * place_y;
        c += about_h, c_x += about_h * place_x, c_y += about_h * place_y;

        gyro_yaw += spin_rate * g_h;
        gyro_heading += spin_rate * (g_n - w->axle_inertia * yaw_rate) - yaw_rate * g_k;
        torques += w->torque;
        power += w->torque * spin_rate;
        odometry_x += w->per_spin_x * spin_rate;
        odometry_y += w->per_spin_y * spin_rate;
        contacts[i] = (Contact){place_x, place_y, force_h, force_k, roller_torque, -(force_h * slip_h + force_k * slip_k),
                                w->torque - yaw_rate * g_h};
        dy[SPIN_ANGLE + i] = spin_rate;
        if (followed) followed->slip_square[i] = slip_square, followed->power[i] = w->torque * spin_rate;
    }

    /* loads N = b_0 + b_1 x + b_2 y: their sum and the two moments of tilt, with theta'' = (z . b + gyro_yaw) / I_z in
     * them; b_0 goes out with the first row */
    double along_y = m->moment_y * m->yaw_mobility, along_x = m->moment_x * m->yaw_mobility;
    double right_k = yaw_rate * yaw_rate * m->moment_x - torques + along_y * gyro_yaw;
    double right_h = yaw_rate * yaw_rate * m->moment_y + gyro_heading - along_x * gyro_yaw;
    double mean_x = sum_x * (1.0 / WHEELS), mean_y = sum_y * (1.0 / WHEELS), mean = m->weight * (1.0 / WHEELS);
    a -= along_y * z, a_x -= along_y * z_x, a_y -= along_y * z_y;
    c += along_x * z, c_x += along_x * z_x, c_y += along_x * z_y;
    double a_1 = a_x - a * mean_x, a_2 = a_y - a * mean_y, a_0 = right_k - a * mean;
    double c_1 = c_x - c * mean_x, c_2 = c_y - c * mean_y, c_0 = right_h - c * mean;
    double scale = 1.0 / (a_1 * c_2 - a_2 * c_1);
    double b_1 = (a_0 * c_2 - a_2 * c_0) * scale, b_2 = (a_1 * c_0 - a_0 * c_1) * scale;
    double b_0 = mean - mean_x * b_1 - mean_y * b_2;

    double heat = 0.0;
    for (int i = 0; i < WHEELS; i++) {
        const Wheel *w = &m->wheels[i];
        const Contact *at = &contacts[i];
        double load = b_0 + b_1 * at->x + b_2 * at->y;
        double roller_torque = at->roller_torque * load;
        heat += at->heat * load;
        dy[SPIN_RATE + i] = (at->free_spin - w->radius * at->force_h * load - w->sin_psi * roller_torque) * w->spin_mobility;
        dy[ROLLER_RATE + i] = roller_torque * w->axial_mobility;
        if (followed) {
            followed->load[i] = load;
            followed->friction_square[i] = (at->force_h * at->force_h + at->force_k * at->force_k) * (load * load);
        }
    }
    if (followed) {
        double x_error = y[X] - m->centre_x * cos_yaw + m->centre_y * sin_yaw - y[ODOMETRY_X];
        double y_error = y[Y] - m->centre_x * sin_yaw - m->centre_y * cos_yaw - y[ODOMETRY_Y];
        followed->position_square = x_error * x_error + y_error * y_error;
        followed->yaw = odometry_yaw - y[YAW];
    }
    double force_h = (f * b_0 + f_x * b_1 + f_y * b_2) * m->mobility, force_k = (g * b_0 + g_x * b_1 + g_y * b_2) * m->mobility;
    dy[X] = y[V_X];
    dy[Y] = y[V_Y];
    dy[YAW] = yaw_rate;
    dy[V_X] = force_h * cos_yaw - force_k * sin_yaw;
    dy[V_Y] = force_h * sin_yaw + force_k * cos_yaw;
    dy[YAW_RATE] = (z * b_0 + z_x * b_1 + z_y * b_2 + gyro_yaw) * m->yaw_mobility;
    dy[FRICTION_LOSS] = heat;
    dy[DRIVE_WORK] = power;
    dy[ODOMETRY_X] = odometry_x * cos_odometry - odometry_y * sin_odometry;
    dy[ODOMETRY_Y] = odometry_x * sin_odometry + odometry_y * cos_odometry;
}

/* out = the state after a step of length h from y, whose derivative is k1 */
static void step(const Machine *m, const Mode *mode, const double *y, const double *k1, double h, double *out)
{
    double k2[STATES], k3[STATES], k4[STATES], stage[STATES];
    for (int i = 0; i < STATES; i++) stage[i] = y[i] + 0.5 * h * k1[i];
    rhs(m, mode, stage, k2, NULL);
    for (int i = 0; i < STATES; i++) stage[i] = y[i] + 0.5 * h * k2[i];
    rhs(m, mode, stage, k3, NULL);
    for (int i = 0; i < STATES; i++) stage[i] = y[i] + h * k3[i];
    rhs(m, mode, stage, k4, NULL);
    for (int i = 0; i < STATES; i++) out[i] = y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
}

/* how far the spin angle of wheel i still is from the end of the roller ahead: negative when that roller is left */
static inline double to_end(const Machine *m, const Mode *mode, const double *y, int i, int direction)
{
    const Wheel *w = &m->wheels[i];
    return direction * (w->phase + w->alpha * (2 * mode[i].roller + direction) - y[SPIN_ANGLE + i]);
}

static inline long place_of(const Machine *m, long roller)
{
    return (roller % m->rollers + m->rollers) % m->rollers;
}

/* put a roller of wheel i into contact: its rate enters the state, the sums of the others are taken anew */
static void take(const Machine *m, Mode *mode, double *y, const double *rates, int i, long roller)
{
    long here = place_of(m, roller);
    double alpha = m->wheels[i].alpha;
    Mode *of = &mode[i];
    rates += i * m->rollers;
    of->roller = roller;
    of->air_cos = of->air_sin = of->air_sum = 0.0;
    for (long j = 0; j < m->rollers; j++) {
        if (j == here) continue;
        of->air_cos += rates[j] * cos(2.0 * alpha * (j - here));
        of->air_sin += rates[j] * sin(2.0 * alpha * (j - here));
        of->air_sum += rates[j];
    }
    y[ROLLER_RATE + i] = rates[here];
}

static void release(const Machine *m, const Mode *mode, const double *y, double *rates, int i)
{
    rates[i * m->rollers + place_of(m, mode[i].roller)] = y[ROLLER_RATE + i];
}

static inline void widen(double *least, double *most, double value)
{
    if (value < *least) *least = value;
    if (value > *most) *most = value;
}

static inline void follow(double *extremes, const Followed *now)
{
    for (int i = 0; i < WHEELS; i++) {
        double *of = &extremes[i * OF_WHEEL];
        if (now->friction_square[i] > of[FRICTION_SQUARE]) of[FRICTION_SQUARE] = now->friction_square[i];
        if (now->slip_square[i] > of[SLIP_SQUARE]) of[SLIP_SQUARE] = now->slip_square[i];
        widen(&of[LEAST_LOAD], &of[MOST_LOAD], now->load[i]);
        widen(&of[LEAST_POWER], &of[MOST_POWER], now->power[i]);
    }
    if (now->position_square > extremes[POSITION_SQUARE]) extremes[POSITION_SQUARE] = now->position_square;
    widen(&extremes[LEAST_YAW], &extremes[MOST_YAW], now->yaw);
}

static void begin_interval(double *extremes, const Followed *now)
{
    for (int i = 0; i < WHEELS; i++) {
        double *of = &extremes[i * OF_WHEEL];
        of[FRICTION_SQUARE] = of[SLIP_SQUARE] = 0.0;
        of[LEAST_LOAD] = of[LEAST_POWER] = INFINITY;
        of[MOST_LOAD] = of[MOST_POWER] = -INFINITY;
    }
    extremes[POSITION_SQUARE] = 0.0, extremes[LEAST_YAW] = INFINITY, extremes[MOST_YAW] = -INFINITY;
    follow(extremes, now);
}

/* March `steps` steps; y (STATES) and rates (WHEELS, N_r) go in and out, rows (steps / steps_per_row, STATES) and the
 * extremes of the interval that each ends (steps / steps_per_row, EXTREMES). Returns the exchanges. */
long march(const Machine *m, double *y, double *rates, double dt, long steps, long steps_per_row, double *rows, double *extremes)
{
    Mode mode[WHEELS];
    Followed now;
    long exchanges = 0;
    double k1[STATES], interval[EXTREMES];
    for (int i = 0; i < WHEELS; i++) {
        const Wheel *w = &m->wheels[i];
        take(m, mode, y, rates, i, lround((y[SPIN_ANGLE + i] - w->phase) / (2.0 * w->alpha)));
    }
    rhs(m, mode, y, k1, &now);
    begin_interval(interval, &now);
    for (long n = 1; n <= steps; n++) {
        double rest = dt;
        for (;;) {
            double trial[STATES], h = rest;
            step(m, mode, y, k1, h, trial);
            int leaving = -1, direction = 1; /* the first wheel to leave its roller, since each shortens the step */
            for (int i = 0; i < WHEELS; i++) {
                int ahead = trial[SPIN_RATE + i] < 0.0 ? -1 : 1;
                if (to_end(m, mode, trial, i, ahead) >= 0.0) continue;
                leaving = i;
                direction = ahead;
                for (int j = 0; j < 20; j++) { /* Newton: the spin rate is the derivative of the spin angle */
                    double correction = to_end(m, mode, trial, i, ahead) / (ahead * trial[SPIN_RATE + i]);
                    h += correction;
                    step(m, mode, y, k1, h, trial);
                    if (fabs(correction) < 1e-12 * dt + 1e-15 * n * dt) break;
                }
            }
            for (int i = 0; i < STATES; i++) y[i] = trial[i];
            rhs(m, mode, y, k1, &now);
            follow(interval, &now);
            if (leaving < 0) break;
            rest -= h;
            exchanges++;
            release(m, mode, y, rates, leaving);
            take(m, mode, y, rates, leaving, mode[leaving].roller + direction);
            rhs(m, mode, y, k1, &now);
            follow(interval, &now);
        }
        if (n % steps_per_row == 0) {
            long row = n / steps_per_row - 1;
            for (int i = 0; i < STATES; i++) rows[row * STATES + i] = y[i];
            for (int i = 0; i < EXTREMES; i++) extremes[row * EXTREMES + i] = interval[i];
            begin_interval(interval, &now);
        }
    }
    for (int i = 0; i < WHEELS; i++) release(m, mode, y, rates, i);
    return exchanges;
}
