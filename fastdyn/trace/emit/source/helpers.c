static double entry_of(int n, const double *const *tables, double x)
{
    double i = fabs(x) < 4e18 ? trunc(x) : 0.0;
    if (i < 0.0)
        i += n;
    return tables[0][(int)fmin(fmax(i, 0.0), n - 1)];
}

static int search_left(int n, const double *const *tables, double x)
{
    int low = 0, high = n;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (!(tables[0][middle] >= x))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static int search_right(int n, const double *const *tables, double x)
{
    int low = 0, high = n;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (!(tables[0][middle] > x))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The index of the piece that contains x. */
static int piece_of(int n, const double *const *tables, double x)
{
    const int i = search_right(n, tables, x) - 1;
    return i < 0 ? 0 : i > n - 2 ? n - 2 : i;
}

/* A polynomial in each piece; `count` tables of coefficients follow that of the knots. */
static double piecewise(int n, int count, const double *const *tables, double x)
{
    const int i = piece_of(n, tables, x);
    const double at = x - tables[0][i];
    double result = tables[1][i];
    for (int k = 2; k <= count; k++)
        result = result * at + tables[k][i];
    return result;
}

static double interpolate(int n, const double *const *tables, double x)
{
    const int i = piece_of(n, tables, x);
    const double left = tables[0][i], right = tables[0][i + 1];
    const double low = tables[1][i], high = tables[1][i + 1];
    const double slope = (high - low) / (right - left);
    double result = slope * (x - left) + low;
    if (x != x)
        return x;
    if (x == left)
        return low;
    if (result != result)
        result = slope * (x - right) + high;
    return result != result && low == high ? low : result;
}

/* The factors of a matrix, in place by rows; n rows that were exchanged and n sizes follow. */
static void factorise(int n, int scaled, double *a)
{
    for (int i = 0; i < n; i++) {
        double size = scaled ? 0.0 : 1.0;
        for (int j = 0; scaled && j < n; j++)
            size = fmax(size, fabs(a[i * n + j]));
        for (int j = 0; scaled && j < n; j++)
            a[i * n + j] /= size;
        a[n * n + n + i] = size;
    }
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[best * n + k]))
                best = i;
        a[n * n + k] = best;
        for (int j = 0; best != k && j < n; j++) {
            const double moved = a[k * n + j];
            a[k * n + j] = a[best * n + j];
            a[best * n + j] = moved;
        }
        for (int i = k + 1; i < n; i++) {
            const double share = a[i * n + k] /= a[k * n + k];
            for (int j = k + 1; share != 0.0 && j < n; j++)
                a[i * n + j] -= share * a[k * n + j];
        }
    }
}

static int is_singular(int n, int scaled, const double *a)
{
    const double least = scaled ? n * 2.220446049250313e-16 : 0.0;
    for (int k = 0; k < n; k++)
        if (fabs(a[k * n + k]) <= least)
            return 1;
    return 0;
}

/* The solution for a right-hand side, in place. */
static void solved(int n, int transposed, const double *a, double *b)
{
    for (int i = 0; !transposed && i < n; i++)
        b[i] /= a[n * n + n + i];
    for (int k = 0; !transposed && k < n; k++) {
        const int best = (int)a[n * n + k];
        const double moved = b[k];
        b[k] = b[best];
        b[best] = moved;
    }
    for (int k = 0; k < n; k++) {
        for (int j = 0; j < k; j++)
            b[k] -= (transposed ? a[j * n + k] : a[k * n + j]) * b[j];
        if (transposed)
            b[k] /= a[k * n + k];
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            b[k] -= (transposed ? a[j * n + k] : a[k * n + j]) * b[j];
        if (!transposed)
            b[k] /= a[k * n + k];
    }
    for (int k = n - 1; transposed && k >= 0; k--) {
        const int best = (int)a[n * n + k];
        const double moved = b[k];
        b[k] = b[best];
        b[best] = moved;
    }
    for (int i = 0; transposed && i < n; i++)
        b[i] /= a[n * n + n + i];
}
