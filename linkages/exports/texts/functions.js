/* Solution of a linear system by elimination with row exchanges, then its determinant.
   a: the matrix row by row, then the right-hand side. */
function solve(n, a) {
  const right = n * n;
  let determinant = 1;
  for (let k = 0; k < n; k++) {
    let pivot = k;
    for (let i = k + 1; i < n; i++) {
      if (abs(a[n * i + k]) > abs(a[n * pivot + k])) pivot = i;
    }
    if (pivot !== k) {
      for (let j = k; j < n; j++) {
        [a[n * k + j], a[n * pivot + j]] = [a[n * pivot + j], a[n * k + j]];
      }
      [a[right + k], a[right + pivot]] = [a[right + pivot], a[right + k]];
      determinant = -determinant;
    }
    determinant *= a[n * k + k];
    for (let i = k + 1; i < n; i++) {
      const factor = a[n * i + k] / a[n * k + k];
      for (let j = k + 1; j < n; j++) a[n * i + j] -= factor * a[n * k + j];
      a[right + i] -= factor * a[right + k];
    }
  }
  const found = new Array(n + 1);
  found[n] = determinant;
  for (let k = n - 1; k >= 0; k--) {
    let rest = a[right + k];
    for (let j = k + 1; j < n; j++) rest -= a[n * k + j] * found[j];
    found[k] = rest / a[n * k + k];
  }
  return found;
}

/* Value, slope and curvature of piecewise cubics: count + 1 knots from p[place] on, then four
   coefficients for each interval; straight lines beyond their ends. */
function spline(t, p, place, count, periodic) {
  const first = p[place], last = p[place + count];
  if (periodic) t -= floor((t - first) / (last - first)) * (last - first);
  const inner = Math.min(Math.max(t, first), last);
  let low = 0, high = count;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (p[place + middle] <= inner) low = middle;
    else high = middle;
  }
  const at = place + count + 1 + 4 * low;
  const d = p[at], c = p[at + 1], b = p[at + 2], a = p[at + 3];
  const x = inner - p[place + low], outside = t - inner;
  const slope = b + x * (2 * c + x * 3 * d);
  const value = a + x * (b + x * (c + x * d)) + outside * slope;
  return [value, slope, outside === 0 ? 2 * c + 6 * d * x : 0];
}
