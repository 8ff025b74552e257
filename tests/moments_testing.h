/* The moment paper's algorithms as printed, in double, for tests. b[0] = 1 and z is in [-1,1];
 * results are visibilities, 1 - shadow intensity. */
#ifndef GN_TESTS_MOMENTS_TESTING_H
#define GN_TESTS_MOMENTS_TESTING_H

#include <math.h>
#include <string.h>

/* Gaussian elimination with pivots. */
static inline void solve3(const double matrix[3][3], const double right[3], double x[3])
{
    double a[3][4];
    for (int i = 0; i < 3; i++) {
        memcpy(a[i], matrix[i], sizeof matrix[i]);
        a[i][3] = right[i];
    }
    for (int i = 0; i < 3; i++) {
        int pivot = i;
        for (int r = i + 1; r < 3; r++)
            if (fabs(a[r][i]) > fabs(a[pivot][i]))
                pivot = r;
        for (int c = 0; c < 4; c++) {
            const double swap = a[i][c];
            a[i][c] = a[pivot][c];
            a[pivot][c] = swap;
        }
        for (int r = 0; r < 3; r++)
            if (r != i) {
                const double factor = a[r][i] / a[i][i];
                for (int c = i; c < 4; c++)
                    a[r][c] -= factor * a[i][c];
            }
    }
    for (int i = 0; i < 3; i++)
        x[i] = a[i][3] / a[i][i];
}

/* Algorithm 1. */
static inline double algorithm_1(const double b[5], double z)
{
    const double hankel[3][3] = {{b[0], b[1], b[2]}, {b[1], b[2], b[3]}, {b[2], b[3], b[4]}};
    double q[3], w[3];
    solve3(hankel, (const double[]){1.0, z, z * z}, q);
    const double p = q[1] / q[2], root = sqrt(fmax(0.25 * p * p - q[0] / q[2], 0.0));
    const double x[3] = {z, -0.5 * p - root, -0.5 * p + root};
    const double vandermonde[3][3] = {
        {1.0, 1.0, 1.0}, {x[0], x[1], x[2]}, {x[0] * x[0], x[1] * x[1], x[2] * x[2]}};
    solve3(vandermonde, b, w);
    double shadow = 0.0;
    for (int i = 1; i < 3; i++)
        shadow += x[i] < z ? w[i] : 0.0;
    return 1.0 - shadow;
}

typedef struct nonlinear {
    double y1, y2, v2, xi4;
} nonlinear;

/* Algorithm 2, with xi4 by Equation 1. */
static inline nonlinear algorithm_2(const double b[5])
{
    const double q2 = b[2] - b[1] * b[1], q1 = b[1] * b[2] - b[3];
    const double q0 = -b[1] * q1 - b[2] * q2;
    const double root = sqrt(q1 * q1 - 4.0 * q2 * q0);
    nonlinear n = {.y1 = (-q1 - root) / (2.0 * q2), .y2 = (-q1 + root) / (2.0 * q2)};
    n.v2 = (b[1] - n.y1) / (n.y2 - n.y1);
    n.xi4 = b[4] - (1.0 - n.v2) * pow(n.y1, 4.0) - n.v2 * pow(n.y2, 4.0);
    return n;
}

/* Equation 4. */
static inline void equation_4(nonlinear n, double b[5])
{
    for (int i = 0; i < 5; i++)
        b[i] = (1.0 - n.v2) * pow(n.y1, i) + n.v2 * pow(n.y2, i);
    b[4] += n.xi4;
}

/* Algorithm 3; the last summand divided by xi4', where the paper prints a product. */
static inline double algorithm_3(nonlinear n, double z)
{
    if (z <= n.y1)
        return 1.0;
    const double width = n.y2 - n.y1, t = (z - n.y1) / width, xi4 = n.xi4 / pow(width, 4.0);
    double x = t;
    if (z <= n.y2) {
        const double q0 = -xi4 / ((1.0 - n.v2) * t);
        const double q1 = -q0 * (n.v2 - t) / (n.v2 - n.v2 * t) - 1.0;
        x = -0.5 * q1 - sqrt(0.25 * q1 * q1 - q0);
    }
    const double w = 1.0 / ((1.0 - x) * (1.0 - x) / (1.0 - n.v2) + x * x / n.v2 +
                            (1.0 - x) * (1.0 - x) * x * x / xi4);
    return z <= n.y2 ? 1.0 - w : w;
}

#endif
