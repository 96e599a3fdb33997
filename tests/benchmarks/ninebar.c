/* The nine-bar press mechanism with one clearance, written by hand: the yardstick for kernels.
 *
 *   cc -O3 -march=native -o ninebar ninebar.c -lm && ./ninebar [STEPS [END]]
 *
 * Integrates the clearance angle with RK4 from the start of tests/data/ninebar_states.json and
 * prints the final state, the nanoseconds per evaluation of the right-hand side, and the seconds.
 * Bodies are treated one by one, as one would do on paper (equation numbers are the paper's).
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct { double x, y; } vec;

static inline vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y}; }
static inline vec sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y}; }
static inline vec scale(double k, vec a) { return (vec){k * a.x, k * a.y}; }
static inline vec turned(vec a) { return (vec){-a.y, a.x}; }
static inline double dot(vec a, vec b) { return a.x * b.x + a.y * b.y; }
static inline vec middle(vec a, vec b) { return scale(0.5, add(a, b)); }

/* Tab. 1 */
static const double L1 = 0.300, L2 = 0.893, L3 = 0.962, L4 = 0.100, L5 = 1.100;
static const double L6 = 0.850, L7 = 0.623, L8 = 0.850;
static const double m2 = 2.836, m3 = 3.051, m6 = 2.701, m7 = 1.993, m8 = 2.701, m9 = 4.288;
static const double J2 = 1.957e-1, J3 = 2.437e-1, J6 = 1.693e-1, J7 = 6.818e-2, J8 = 1.693e-1;
static const double gravity = 9.81, clearance = 1.5e-4, omega1 = -M_PI, omega4 = M_PI;

/* Two links of squared lengths a2, b2 over the gap d: the first link, and 1 / (first x second). */
static inline vec dyad(vec d, double a2, double b2, double side, double *inverse) {
  double i = 1.0 / dot(d, d), u = 0.5 + 0.5 * (a2 - b2) * i, h = side * sqrt(a2 * i - u * u);
  *inverse = -i / h;
  return add(scale(u, d), scale(h, turned(d)));
}

/* What one body adds to J33 and to the remaining terms of the third row of Eq. 4. */
static inline void body(double m, double J, vec u, double wu, vec a, double wa, double *J33,
                        double *rest) {
  a.x -= gravity;
  *J33 += m * dot(u, u) + J * wu * wu;
  *rest += m * dot(a, u) + J * wa * wu;
}

typedef struct { vec A, C, vA, vC, aA, aC; } cranks;

static inline cranks clock_part(double t) {
  double s1, c1, s4, c4;
  sincos(0.5 + omega1 * t, &s1, &c1);
  sincos(1.0 + omega4 * t, &s4, &c4);
  vec A = {L1 * c1, L1 * s1}, C = {L4 * c4, L4 * s4};
  return (cranks){A, {L5 + C.x, C.y}, scale(omega1, turned(A)), scale(omega4, turned(C)),
                  scale(-omega1 * omega1, A), scale(-omega4 * omega4, C)};
}

static inline double acceleration(const cranks *k, double alpha, double speed) {
  double s, c;
  sincos(alpha, &s, &c);
  vec r = {clearance * c, clearance * s}, K = add(k->C, r);

  /* positions */
  double iB, iE;
  vec d = sub(K, k->A), AB = dyad(d, L2 * L2, L3 * L3, 1.0, &iB), BK = sub(d, AB);
  vec B = add(k->A, AB), OE = dyad(B, L6 * L6, L7 * L7, -1.0, &iE), EB = sub(B, OE);
  double fx = sqrt(L8 * L8 - OE.y * OE.y), ifx = 1.0 / fx;

  /* partial velocities with respect to alpha */
  vec uK = turned(r);
  double u2 = dot(uK, BK) * iB, u3 = -dot(uK, AB) * iB;
  vec uB = scale(u2, turned(AB));
  double u6 = dot(uB, EB) * iE, u7 = -dot(uB, OE) * iE;
  vec uE = scale(u6, turned(OE));
  double u8 = -uE.y * ifx, u9 = uE.x + u8 * OE.y;

  /* velocities */
  vec vK = add(k->vC, scale(speed, uK)), w = sub(vK, k->vA);
  double w2 = dot(w, BK) * iB, w3 = -dot(w, AB) * iB;
  vec vB = add(k->vA, scale(w2, turned(AB)));
  double w6 = dot(vB, EB) * iE, w7 = -dot(vB, OE) * iE;
  double w8 = -w6 * OE.x * ifx;

  /* accelerations while alpha does not accelerate */
  vec aK = sub(k->aC, scale(speed * speed, r));
  vec p = add(sub(aK, k->aA), add(scale(w2 * w2, AB), scale(w3 * w3, BK)));
  double e2 = dot(p, BK) * iB, e3 = -dot(p, AB) * iB;
  vec aB = add(k->aA, sub(scale(e2, turned(AB)), scale(w2 * w2, AB)));
  p = add(aB, add(scale(w6 * w6, OE), scale(w7 * w7, EB)));
  double e6 = dot(p, EB) * iE, e7 = -dot(p, OE) * iE;
  vec aE = sub(scale(e6, turned(OE)), scale(w6 * w6, OE));
  double e8 = (-w8 * w8 * OE.y - aE.y) * ifx, a9 = aE.x + e8 * OE.y - w8 * w8 * fx;

  /* energies, body by body; cranks 1 and 4 do not move with alpha */
  double J33 = 0.0, rest = 0.0;
  body(m2, J2, scale(0.5, uB), u2, middle(k->aA, aB), e2, &J33, &rest);
  body(m3, J3, middle(uK, uB), u3, middle(aK, aB), e3, &J33, &rest);
  body(m6, J6, scale(0.5, uE), u6, scale(0.5, aE), e6, &J33, &rest);
  body(m7, J7, middle(uE, uB), u7, middle(aE, aB), e7, &J33, &rest);
  body(m8, J8, (vec){0.5 * (uE.x + u9), 0.5 * uE.y}, u8,
       (vec){0.5 * (aE.x + a9), 0.5 * aE.y}, e8, &J33, &rest);
  body(m9, 0.0, (vec){u9, 0.0}, 0.0, (vec){a9, 0.0}, 0.0, &J33, &rest);
  return -rest / J33;
}

static double rate(double t, double alpha, double speed) {
  cranks k = clock_part(t);
  return acceleration(&k, alpha, speed);
}

int main(int count, char **arguments) {
  long steps = count > 1 ? atol(arguments[1]) : 2000000;
  double end = count > 2 ? atof(arguments[2]) : 200.0, h = end / steps;
  double q = 0.0, v = 0.0;
  struct timespec begin, finish;
  clock_gettime(CLOCK_MONOTONIC, &begin);
  for (long i = 0; i < steps; i++) {
    double t = i * h;
    double a1 = rate(t, q, v), v2 = v + 0.5 * h * a1;
    double a2 = rate(t + 0.5 * h, q + 0.5 * h * v, v2), v3 = v + 0.5 * h * a2;
    double a3 = rate(t + 0.5 * h, q + 0.5 * h * v2, v3), v4 = v + h * a3;
    double a4 = rate(t + h, q + h * v3, v4);
    q += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  clock_gettime(CLOCK_MONOTONIC, &finish);
  double seconds = (finish.tv_sec - begin.tv_sec) + 1e-9 * (finish.tv_nsec - begin.tv_nsec);
  printf("%.15g %.15g %.3f %.6f\n", q, v, 1e9 * seconds / (4.0 * steps), seconds);
  return 0;
}
