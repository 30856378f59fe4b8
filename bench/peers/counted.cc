/* A C loop with numbers that count what is done to them: compiled with -DSOURCE="FILE.c" -DSYSTEM=NAME, its constants.
 *
 * An operation is counted where the source has one, unless all its operands are constants. Each result is ready at a
 * time: as soon as its operands are and the operation has taken its latency, as if nothing else ever held it up.
 */
#include <cmath>
#include <math.h>
#include <stddef.h>

enum { ADDITION, MULTIPLICATION, DIVISION, ROOT, SINE_OR_COSINE, READ, WRITE, KINDS };

extern "C" {
long counts[KINDS];
double latency[KINDS]; /* of the operations */
}

struct Counted {
    double value;
    double ready; /* constants: since ever */
    long stored;  /* an element of an array; the others are results on their way */

    Counted() : stored(1) {}
    Counted(double value, double ready = -INFINITY) : value(value), ready(ready), stored(0) {}
    Counted(const Counted &other) : value(other.load()), ready(other.ready), stored(0) {}
    Counted &operator=(const Counted &other)
    {
        value = other.load();
        ready = other.ready;
        counts[WRITE] += stored;
        return *this;
    }
    double load() const
    {
        counts[READ] += stored;
        return value;
    }
    Counted operator-() const { return Counted(-load(), ready); }
};

static Counted result(int kind, double value, double ready)
{
    counts[kind] += ready > -INFINITY;
    return Counted(value, ready + latency[kind]);
}

static double later(const Counted &a, const Counted &b) { return fmax(a.ready, b.ready); }
static Counted operator+(const Counted &a, const Counted &b) { return result(ADDITION, a.load() + b.load(), later(a, b)); }
static Counted operator-(const Counted &a, const Counted &b) { return result(ADDITION, a.load() - b.load(), later(a, b)); }
static Counted operator*(const Counted &a, const Counted &b)
{
    return result(MULTIPLICATION, a.load() * b.load(), later(a, b));
}
static Counted operator/(const Counted &a, const Counted &b) { return result(DIVISION, a.load() / b.load(), later(a, b)); }
static Counted &operator+=(Counted &a, const Counted &b) { return a = a + b; }
static Counted &operator-=(Counted &a, const Counted &b) { return a = a - b; }
static Counted sqrt(const Counted &a) { return result(ROOT, sqrt(a.load()), a.ready); }
static Counted sin(const Counted &a) { return result(SINE_OR_COSINE, sin(a.load()), a.ready); }
static Counted cos(const Counted &a) { return result(SINE_OR_COSINE, cos(a.load()), a.ready); }
static Counted fabs(const Counted &a) { return Counted(fabs(a.load()), a.ready); }
static bool operator<(const Counted &a, const Counted &b) { return a.load() < b.load(); }
static bool operator>(const Counted &a, const Counted &b) { return a.load() > b.load(); }
static bool operator>=(const Counted &a, const Counted &b) { return a.load() >= b.load(); }
static long lround(const Counted &a) { return lround(a.load()); }

extern "C" {
#define double Counted
#include SOURCE

/* one right-hand side; its value does not matter */
void evaluate(const SYSTEM *system, const double *y, double *dy)
{
    static Mode mode[8];
    rhs(system, mode, y, dy, NULL);
}
}
