/*: solve( */
/* Solution of a linear system by elimination with row exchanges, then its determinant.
   a: the matrix row by row, then the right-hand side. */
static void solve(int n, double *a, double *found) {
  double *right = a + n * n, determinant = 1;
  for (int k = 0; k < n; k++) {
    int pivot = k;
    for (int i = k + 1; i < n; i++) {
      if (fabs(a[n * i + k]) > fabs(a[n * pivot + k])) pivot = i;
    }
    if (pivot != k) {
      for (int j = k; j < n; j++) {
        const double other = a[n * k + j];
        a[n * k + j] = a[n * pivot + j];
        a[n * pivot + j] = other;
      }
      const double other = right[k];
      right[k] = right[pivot];
      right[pivot] = other;
      determinant = -determinant;
    }
    determinant *= a[n * k + k];
    for (int i = k + 1; i < n; i++) {
      const double factor = a[n * i + k] / a[n * k + k];
      for (int j = k + 1; j < n; j++) a[n * i + j] -= factor * a[n * k + j];
      right[i] -= factor * right[k];
    }
  }
  found[n] = determinant;
  for (int k = n - 1; k >= 0; k--) {
    double rest = right[k];
    for (int j = k + 1; j < n; j++) rest -= a[n * k + j] * found[j];
    found[k] = rest / a[n * k + k];
  }
}

/*: spline( */
/* Value, slope and curvature of piecewise cubics: count + 1 knots, then four coefficients for each
   interval; straight lines beyond their ends. */
static void spline(double t, const double *knots, int count, int periodic, double *found) {
  const double first = knots[0], last = knots[count];
  if (periodic) t -= floor((t - first) / (last - first)) * (last - first);
  const double inner = fmin(fmax(t, first), last);
  int low = 0, high = count;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (knots[middle] <= inner) low = middle;
    else high = middle;
  }
  const double *own = knots + count + 1 + 4 * low;
  const double d = own[0], c = own[1], b = own[2], a = own[3];
  const double x = inner - knots[low], outside = t - inner;
  const double slope = b + x * (2 * c + x * 3 * d);
  found[0] = a + x * (b + x * (c + x * d)) + outside * slope;
  found[1] = slope;
  found[2] = outside == 0 ? 2 * c + 6 * d * x : 0;
}

