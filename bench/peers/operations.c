/* What arithmetic costs: `n` operations of which each needs the one before, and n times LANES that need not. */
#include <math.h>

enum { LANES = 12 };

#define OPERATION(NAME, RESULT)                                         \
    double chain_##NAME(long n, double a)                               \
    {                                                                   \
        double x = a;                                                   \
        for (long i = 0; i < n; i++) x = RESULT;                        \
        return x;                                                       \
    }                                                                   \
    double lanes_##NAME(long n, double a)                               \
    {                                                                   \
        double lanes[LANES], sum = 0.0;                                 \
        for (int j = 0; j < LANES; j++) lanes[j] = a + 1e-3 * j;        \
        for (long i = 0; i < n; i++)                                    \
            for (int j = 0; j < LANES; j++) {                           \
                double x = lanes[j];                                    \
                lanes[j] = RESULT;                                      \
            }                                                           \
        for (int j = 0; j < LANES; j++) sum += lanes[j];                \
        return sum;                                                     \
    }

OPERATION(addition, x + a)
OPERATION(multiplication, x * a)
OPERATION(division, a / x)
OPERATION(root, sqrt(x * a))
OPERATION(sine_and_cosine, a * (sin(x) + cos(x)))
