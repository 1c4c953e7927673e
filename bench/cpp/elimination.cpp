// Gaussian elimination with partial pivoting, as loops over columns.

#include <cmath>

// Solves A x = b; a has A by columns and receives the factors, b receives x.
extern "C" int solve(long n, double* __restrict a, double* __restrict b) {
    for (long k = 0; k < n; ++k) {
        double* column = a + k * n;
        long pivot = k;
        for (long i = k + 1; i < n; ++i)
            if (std::fabs(column[i]) > std::fabs(column[pivot])) pivot = i;
        if (column[pivot] == 0.0) return 1;
        if (pivot != k) {
            for (long j = 0; j < n; ++j) {
                double x = a[j * n + k];
                a[j * n + k] = a[j * n + pivot];
                a[j * n + pivot] = x;
            }
            double x = b[k];
            b[k] = b[pivot];
            b[pivot] = x;
        }
        double scale = 1.0 / column[k];
        for (long i = k + 1; i < n; ++i) column[i] *= scale;
        for (long j = k + 1; j < n; ++j) {
            double* other = a + j * n;
            double x = other[k];
            for (long i = k + 1; i < n; ++i) other[i] -= x * column[i];
        }
        double x = b[k];
        for (long i = k + 1; i < n; ++i) b[i] -= x * column[i];
    }
    for (long k = n - 1; k >= 0; --k) {
        double x = b[k] = b[k] / a[k * n + k];
        for (long i = 0; i < k; ++i) b[i] -= x * a[k * n + i];
    }
    return 0;
}

// `count` solutions of one system, for the clock.
extern "C" void solve_many(long count, long n, const double* m, const double* v, double* a, double* b) {
    for (long c = 0; c < count; ++c) {
        for (long i = 0; i < n * n; ++i) a[i] = m[i];
        for (long i = 0; i < n; ++i) b[i] = v[i];
        solve(n, a, b);
    }
}
