/* One contact, in its own frame: D = [w b^T; b S], S = diag(s), with everything else held
 * (Jourdan, Alart, Jean, Comput. Methods Appl. Mech. Eng. 155 (1998) 31). Where it slides,
 * u_T = -l r_T with l > 0, so that
 *
 *   r_T = -(S + l)^-1 (q_T + b r_N),   u_N = 0:  r_N = (b . p - q_N) / (w - b . g),
 *   p = (S + l)^-1 q_T,  g = (S + l)^-1 b,   and l is the root of  |r_T| - mu r_N,
 *
 * which is > 0 at l = 0, as it does not stick there, and < 0 at infinity. The root is kept in a
 * bracket and approached by secants, from the root of the sweep before and what would be the root
 * next to it if S were a number (as of the radius of a trust region: More and Sorensen, SIAM J.
 * Sci. Stat. Comput. 4 (1983) 553): two or three values as a rule. */
#include "one_contact.h"

#include <float.h>
#include <math.h>

#include "cone.h"

/* |r_T| - mu r_N at l, with r. */
static double excess(const double *D, const double *q, double mu, double l, double *r)
{
  double s1 = 1 / (D[4] + l), s2 = 1 / (D[8] + l);
  double p1 = s1 * q[1], p2 = s2 * q[2], g1 = s1 * D[1], g2 = s2 * D[2];
  r[0] = (D[1] * p1 + D[2] * p2 - q[0]) / (D[0] - D[1] * g1 - D[2] * g2);
  r[1] = -p1 - g1 * r[0];
  r[2] = -p2 - g2 * r[0];
  return nsdae_fc_length(r[1], r[2]) - mu * r[0];
}

/* Of l with its r the next one, so that |r_T| = mu r_N if S were a number s and b zero, where
 * (s + l) |r_T| does not depend on l. */
static double rescaled(const double *D, double mu, double l, const double *r)
{
  double s = (D[4] + D[8]) / 2;
  return (s + l) * (nsdae_fc_length(r[1], r[2]) / (mu * r[0])) - s;
}

/* The root, from the guess on, kept in a bracket: secants while they halve the excess, else what it
 * would be if S were a number, else the middle. */
static double frictional_joint(const double *D, const double *q, double mu, double guess,
                               double tol, double *r)
{
  double low = 0, high = INFINITY, before = 0, at_before = 0;
  double l = guess > 0 ? guess : rescaled(D, mu, 0, r);
  if (!(l > low && l < high)) l = D[4] + D[8];
  for (int k = 0, failed = 1; k < 200 && low < (1 - 2 * DBL_EPSILON) * high; k++) {
    double f = excess(D, q, mu, l, r);
    if (fabs(f) <= tol * mu * r[0]) return l;
    if (f > 0)
      low = l;
    else
      high = l;
    if (k > 0) failed = fabs(f) <= 0.5 * fabs(at_before) ? 0 : failed + 1;
    double next = failed == 0 ? l - f * ((l - before) / (f - at_before)) : rescaled(D, mu, l, r);
    before = l, at_before = f;
    if (failed < 3 && next > low && next < high)
      l = next;
    else if (!(high < INFINITY)) /* inside the bracket, whatever its ends */
      l *= 16;
    else
      l = low > 0 ? sqrt(low) * sqrt(high) : high / 256;
  }
  l = high < INFINITY ? high : l;
  excess(D, q, mu, l, r);
  return l;
}

void nsdae_fc_solve_contact(const double *D, const double *q, double mu, double tol, double *slip,
                            double *r)
{
  if (q[0] >= 0) {
    r[0] = r[1] = r[2] = 0;
    return;
  }
  double f = excess(D, q, mu, 0, r);
  if (f <= 0) {
    *slip = 0;
    return;
  }
  *slip = frictional_joint(D, q, mu, *slip, tol, r);
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
