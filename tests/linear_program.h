/* A small linear program for tests: of all distributions over given places with given means, the
 * one that gives most light to a receiver. */
#ifndef GN_TESTS_LINEAR_PROGRAM_H
#define GN_TESTS_LINEAR_PROGRAM_H

#include <math.h>
#include <string.h>

#define LP_ROWS    5
#define LP_PLACES  3000
#define LP_PENALTY 1000.0

/* Solves a x = right, or its transpose, by elimination with pivots. */
static inline void lp_solve(int rows, double matrix[LP_ROWS][LP_ROWS], int transposed,
                            const double *right, double *x)
{
    double a[LP_ROWS][LP_ROWS + 1];
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < rows; k++)
            a[i][k] = transposed ? matrix[k][i] : matrix[i][k];
        a[i][rows] = right[i];
    }
    for (int i = 0; i < rows; i++) {
        int pivot = i;
        for (int r = i + 1; r < rows; r++)
            if (fabs(a[r][i]) > fabs(a[pivot][i]))
                pivot = r;
        for (int c = 0; c <= rows; c++) {
            const double swap = a[i][c];
            a[i][c] = a[pivot][c];
            a[pivot][c] = swap;
        }
        for (int r = 0; r < rows; r++) {
            const double factor = r == i ? 0.0 : a[r][i] / a[i][i];
            for (int c = i; c <= rows; c++)
                a[r][c] -= factor * a[i][c];
        }
    }
    for (int i = 0; i < rows; i++)
        x[i] = a[i][rows] / a[i][i];
}

/* The revised simplex method. Maximizes the weight of the places >= receiver over weights >= 0 with
 * sum_i weight_i place_i^k = b[k] for k < rows. The places must allow such weights. */
static inline double most_light(int rows, const double *b, int count, const double *places,
                                double receiver)
{
    /* Columns are scaled to size 1; negative indices are artificial columns of a large penalty. */
    static double columns[LP_PLACES][LP_ROWS], gain[LP_PLACES];
    for (int i = 0; i < count; i++) {
        const double scale = 1.0 / (1.0 + pow(fabs(places[i]), rows - 1));
        for (int k = 0; k < rows; k++)
            columns[i][k] = scale * pow(places[i], k);
        gain[i] = places[i] >= receiver ? scale : 0.0;
    }
    int basis[LP_ROWS];
    for (int k = 0; k < rows; k++)
        basis[k] = -1 - k;
    for (int round = 0; round < 2000; round++) {
        double matrix[LP_ROWS][LP_ROWS], gains[LP_ROWS], prices[LP_ROWS], step[LP_ROWS];
        double weights[LP_ROWS];
        for (int k = 0; k < rows; k++) {
            for (int r = 0; r < rows; r++)
                matrix[r][k] = basis[k] >= 0        ? columns[basis[k]][r]
                               : r == -1 - basis[k] ? (b[r] < 0.0 ? -1.0 : 1.0)
                                                    : 0.0;
            gains[k] = basis[k] >= 0 ? gain[basis[k]] : -LP_PENALTY;
        }
        lp_solve(rows, matrix, 1, gains, prices);
        lp_solve(rows, matrix, 0, b, weights);
        int enter = -1;
        double best = 1e-9;
        for (int i = 0; i < count; i++) {
            double profit = gain[i];
            for (int k = 0; k < rows; k++)
                profit -= prices[k] * columns[i][k];
            if (profit > best) {
                best = profit;
                enter = i;
            }
        }
        if (enter < 0) {
            double sum = 0.0;
            for (int k = 0; k < rows; k++)
                sum += gains[k] * weights[k];
            return sum;
        }
        lp_solve(rows, matrix, 0, columns[enter], step);
        int leave = -1;
        double length = INFINITY;
        for (int k = 0; k < rows; k++)
            if (step[k] > 1e-12 && fmax(weights[k], 0.0) / step[k] < length) {
                length = fmax(weights[k], 0.0) / step[k];
                leave = k;
            }
        if (leave < 0)
            return INFINITY; /* unbounded: cannot be, the weights sum to 1 */
        basis[leave] = enter;
    }
    return NAN;
}

#endif
