/* One contact, in its own frame: D = [w b^T; b S], S = diag(s), with everything else held
 * (Jourdan, Alart, Jean, Comput. Methods Appl. Mech. Eng. 155 (1998) 31). Where it slides,
 * u_T = -l r_T with l > 0, so that
 *
 *   r_T = -(S + l)^-1 (q_T + b r_N),   u_N = 0:  r_N = (b . p - q_N) / (w - b . g),
 *   p = (S + l)^-1 q_T,  g = (S + l)^-1 b,   and l is the root of  |r_T| - mu r_N,
 *
 * which is > 0 at l = 0, as it does not stick there, and < 0 at infinity. The root is kept in a
 * bracket and approached from the root of the sweep before by Newton's method on mu r_N / |r_T|,
 * which is linear in l if S is a number and b zero (as of the radius of a trust region: More and
 * Sorensen, SIAM J. Sci. Stat. Comput. 4 (1983) 553): two values as a rule. */
#include "one_contact.h"

#include <float.h>
#include <math.h>

/* |r_T| - mu r_N at l, with r and its derivative, and the root by Newton's method on
 * h = mu r_N / |r_T| - 1:
 *
 *   r_N' = g . r_T / (w - b . g),   r_T' = -(S + l)^-1 r_T - g r_N' */
typedef struct slide {
  double r[3], slope[3], root;
} slide;

static inline double excess(const double *D, const double *q, double mu, double l, slide *at)
{
  double s1 = 1 / (D[4] + l), s2 = 1 / (D[8] + l);
  double p1 = s1 * q[1], p2 = s2 * q[2], g1 = s1 * D[1], g2 = s2 * D[2];
  double width = 1 / (D[0] - D[1] * g1 - D[2] * g2);
  double n = (D[1] * p1 + D[2] * p2 - q[0]) * width, a = -p1 - g1 * n, b = -p2 - g2 * n;
  double square = a * a + b * b, length = sqrt(square), f = length - mu * n;
  double dn = (g1 * a + g2 * b) * width, da = -s1 * a - g1 * dn, db = -s2 * b - g2 * dn;
  *at = (slide){{n, a, b}, {dn, da, db}, 0};
  at->root = l + f * square / (mu * (dn * square - n * (a * da + b * db)));
  return f;
}

/* The root from guess on, kept in a bracket; 0: it sticks, which is asked once the method leads
 * there. A step of Newton's method leaves the square of the excess, both relative to mu r_N: if
 * that is within tol, the step needs no other value. Three steps that do not halve the excess are
 * followed by the middle of the bracket. */
static double sliding(const double *D, const double *q, double mu, double guess, double tol,
                      slide *at)
{
  double low = 0, high = INFINITY, before = INFINITY, l = guess;
  int asked = !(guess > 0);
  if (asked && !(excess(D, q, mu, 0, at) > 0)) return 0;
  if (asked) l = at->root > 0 && at->root < INFINITY ? at->root : D[4] + D[8];
  for (int k = 0, failed = 0; k < 200 && low < (1 - 2 * DBL_EPSILON) * high; k++) {
    double f = excess(D, q, mu, l, at), share = fabs(f) / (mu * at->r[0]), next = at->root;
    if (share <= tol && at->r[0] > 0) return l;
    if (share * share <= tol && at->r[0] > 0 && next > low && next < high) {
      for (int j = 0; j < 3; j++) at->r[j] += (next - l) * at->slope[j];
      return next;
    }
    if (f > 0)
      low = l, asked = 1;
    else
      high = l;
    if (!asked && !(next > 0)) {
      asked = 1;
      if (!(excess(D, q, mu, 0, at) > 0)) return 0;
    }
    failed = fabs(f) <= 0.5 * before ? 0 : failed + 1;
    before = fabs(f);
    if (failed < 3 && next > low && next < high)
      l = next;
    else if (!(high < INFINITY)) /* inside the bracket, whatever its ends */
      l *= 16;
    else
      l = low > 0 ? sqrt(low) * sqrt(high) : high / 256;
  }
  if (!asked && !(excess(D, q, mu, 0, at) > 0)) return 0;
  l = high < INFINITY ? high : l;
  excess(D, q, mu, l, at);
  return l;
}

void nsdae_fc_solve_contact(const double *D, const double *q, double mu, double tol, double *slip,
                            double *r)
{
  slide at = {{0}, {0}, 0};
  if (!(q[0] >= 0)) *slip = sliding(D, q, mu, *slip, tol, &at);
  for (int j = 0; j < 3; j++) r[j] = at.r[j];
}

/* The turn that makes the tangential part of D diagonal (one Jacobi rotation: Golub and Van Loan,
 * Matrix Computations, 8.5), and D turned by it. */
void nsdae_fc_turn_matrix(double *D, double *by)
{
  double x = D[1], a = D[4], b = D[8], c = (a - b) / 2;
  double tangent = D[5] == 0 ? 0 : D[5] / (c + copysign(hypot(c, D[5]), c));
  by[0] = 1 / sqrt(1 + tangent * tangent);
  by[1] = tangent * by[0];
  D[4] = by[0] * by[0] * a + 2 * by[0] * by[1] * D[5] + by[1] * by[1] * b;
  D[8] = a + b - D[4];
  D[1] = D[3] = by[0] * x + by[1] * D[2];
  D[2] = D[6] = by[0] * D[2] - by[1] * x;
  D[5] = D[7] = 0;
}

/* Adjugate over determinant, pivot by pivot: each is the rest of its diagonal entry, and keeps
 * ten digits where it is no less than 1e-6 of it. */
void nsdae_fc_invert(const double *D, double *S)
{
  const double e = NSDAE_FC_PROXIMAL, least = 1e-6;
  const double a = D[0] + e, b = D[4] + e, c = D[8] + e;
  const double minor = a * b - D[1] * D[1];
  S[0] = b * c - D[5] * D[5];
  S[1] = D[2] * D[5] - D[1] * c;
  S[2] = D[1] * D[5] - D[2] * b;
  S[3] = a * c - D[2] * D[2];
  S[4] = D[1] * D[2] - a * D[5];
  S[5] = minor;
  const double determinant = a * S[0] + D[1] * S[1] + D[2] * S[2];
  for (int k = 0; k < 6; k++) S[k] /= determinant;
  if (!(a > 0 && minor > least * a * b && determinant > least * minor * c)) S[0] = NAN;
}
