/* Operations on single values and on n values. */
#pragma once

#include "table.h"

static double wrapped(double a) {
    double angle = isinf(a) ? NAN : remainder(a, TWO_PI);
    return angle == -PI ? PI : angle;
}

/* Truth values are 0, 1 or NaN; branch-free, because they are unpredictable. */
static double both(double a, double b) { return a == 0.0 ? 0.0 : b == 0.0 ? 0.0 : a * b; }

static double either(double a, double b) { return a == 1.0 ? 1.0 : b == 1.0 ? 1.0 : a + b; }

static double worst(double a, double b) {
    if (INVALID(a)) return b < 0.0 ? b : NAN;
    if (INVALID(b)) return a < 0.0 ? a : NAN;
    return b < a ? b : a;
}

static double best(double a, double b) { return -worst(-a, -b); }

static int any_invalid(const double *a, int n) {
    int invalid = 0;
    for (int i = 0; i < n; i++) invalid |= INVALID(a[i]);
    return invalid;
}

/* A sum that is not NaN proves that all values are valid. inf - inf is NaN, too; then each value is checked. */
static double least_in_turn(const double *a, int n) {
    double m = a[0], sum = a[0];
    for (int i = 1; i < n; i++) {
        sum += a[i];
        m = a[i] < m ? a[i] : m;
    }
    return INVALID(sum) && any_invalid(a, n) ? NAN : m;
}

#ifdef __SSE2__
/* Unrolled by two, because this is half of the work of common rules. Order affects only the sign of a zero. */
static double least(const double *a, int n) {
    if (n < 4) return least_in_turn(a, n);
    __m128d m = _mm_loadu_pd(a), sum = m;
    for (int i = 2; i < n; i += 2) {
        const __m128d next = _mm_loadu_pd(a + (i + 2 <= n ? i : n - 2));
        sum = _mm_add_pd(sum, next);
        m = _mm_min_pd(next, m);
    }
    const double found = _mm_cvtsd_f64(_mm_min_sd(_mm_unpackhi_pd(m, m), m));
    const double all = _mm_cvtsd_f64(_mm_add_sd(_mm_unpackhi_pd(sum, sum), sum));
    return INVALID(all) || found == 0.0 ? least_in_turn(a, n) : found;
}
#else
#define least least_in_turn
#endif

static double greatest(const double *a, int n) {
    double m = a[0], sum = a[0];
    for (int i = 1; i < n; i++) {
        sum += a[i];
        m = a[i] > m ? a[i] : m;
    }
    return INVALID(sum) && any_invalid(a, n) ? NAN : m;
}

static double argmin(const double *a, int n) {
    double m = least(a, n);
    for (int i = 0; i < n; i++)
        if (a[i] == m) return i;
    return NAN;
}

static double total(const double *a, int n) {
    double sum = a[0];
    for (int i = 1; i < n; i++) sum += a[i];
    return sum;
}

static double dot(const double *a, const double *b, int n) {
    double sum = a[0] * b[0];
    for (int i = 1; i < n; i++) sum += a[i] * b[i];
    return sum;
}

static double count(const double *a, int n) {
    double found = 0.0;
    for (int i = 0; i < n; i++) found += a[i]; /* truth values: 1, 0 or NaN, which stays */
    return found;
}

static double min_valid(const double *a, int n, double wanted) {
    double m = INFINITY;
    int valid = 0;
    for (int i = 0; i < n; i++) {
        valid += !INVALID(a[i]);
        m = a[i] < m ? a[i] : m;
    }
    return valid > 0 && valid >= wanted ? m : NAN;
}

static double folded(double (*fold)(double, double), const double *a, int n) {
    double m = a[0];
    for (int i = 1; i < n; i++) m = fold(m, a[i]);
    return m;
}
