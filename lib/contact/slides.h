/* Frictional joints: |Lambda_T| <= b + mu |lambda| against the sliding velocity xi_T. b is a bound
 * of its own, as of dry friction, a brake or a motor; lambda is the multiplier of a bilateral
 * constraint, as of a slider in a slot without play.
 *
 * Two opposed contacts in its place could carry any preload, and with it any friction. Instead the
 * multiplier is split, lambda = l+ - l-, 0 <= l+ _|_ l- >= 0, which adds three rows a slide:
 *
 *   x = [l+, Lambda_R, xi_L],  y = [l-, xi_R, Lambda_L]
 *   Lambda_T = Lambda_R - mu (l+ + l-),  Lambda_L = mu (l+ + l-) - Lambda_T,  xi_R = xi_T + xi_L
 *
 * With the multipliers lambda_S = lambda_free + D_S Lambda of the frictional joints' constraints,
 * Lambda = Z_b x - mu l- (on the frictional joints) and S the matrix that picks l+ from x,
 *
 *   Q l- = (S - D_S Z_b) x - lambda_free,   Q = 1 - D_SS mu
 *   l- = K x + k0,   Lambda = Z x + z0
 *   Z = Z_b - mu K,   z0 = -mu k0   (on the frictional joints)
 *   l- row: K,   xi_R row: W_S^T P W Z + [xi_L],   Lambda_L row: 2 mu (S + K) - [Lambda_R]
 *
 * With b, Lambda_T = Lambda_R - b - mu (l+ + l-) and Lambda_L = b + mu (l+ + l-) - Lambda_T: z0
 * has -b too, Q l- has D_S b of all joints, and the Lambda_L row has 2 b. Of mu = 0 there is no
 * l+, no l-, and two rows are left.
 *
 * In the complementarity problem a bound far above the load costs the digits of Lambda_R - b: the
 * problem has the bound NSDAE_BOUND_FIRST times the impulse that stops the fastest column, and, if
 * an impulse reaches such a bound, again with NSDAE_BOUND_FURTHER times that.
 *
 * A position motor has F = -k_p e - k_d xi within the bound, of the error e of its coordinate, e' =
 * xi. Of the error e_m and its rate at the middle of the step, the methods have
 *
 *   xi_1 = xi_0 + h F / m,   e_m+1 = e_m + h xi_1
 *
 * With eps = e_m - (1 - theta) h xi_0 that is eps_1 = eps + h (theta xi_1 + (1 - theta) xi_0), and
 * F at theta eps_1 + (1 - theta) eps and the same mean of xi is the theta method (Hairer and
 * Wanner, "Solving Ordinary Differential Equations II", 1996, section IV.3):
 *
 *   F = -k_p (e_m + h theta^2 xi_1 - h (1 - theta)^2 xi_0) - k_d (theta xi_1 + (1 - theta) xi_0)
 *
 * Of a root y / h of m y^2 / h^2 + k_d y / h + k_p = 0 an error changes in a step by the factor
 *
 *   (1 + (1 - theta) y) / (1 - theta y)
 *
 * It is stable for theta >= 1/2, of second order if theta - 1/2 = O(h), and tends to 0 for large y
 * if theta tends to 1. So theta = (1 + z) / (2 + z) with the stiffness z = h (k_d + h k_p) / m: for
 * k_d = 0 and large z the factor is about 1 / sqrt(z). With c = 1 / (theta k_d
 * + h theta^2 k_p) the row is
 *
 *   xi_1 + (c / h) Lambda_T + r = 0 within the bound,
 *   r = c (k_p (e_m - h (1 - theta)^2 xi_0) + k_d (1 - theta) xi_0)
 *
 * 1 / m is W_S^T M^-1 W_S. Soft gains make c / h and r large: the row times s and Lambda_T / s, s^2
 * = 1 / (1 + m c / h), have the diagonal entry 1 / m and, as offset, about the velocity omega e of
 * a vibration. W_S is scaled by s, s^2 c / h is added to G_jj and s r to the offset of its column:
 * nsdae_joint_row. In event and penalty the force is known from the state, and there is no row.
 *
 * Where the direction of sliding s = +-1 is known, l+ is the only row left, its complement l-, and
 * Lambda_T = -s mu (l+ + l-): s mu takes the place of mu, and Lambda_R and xi_L are left out.
 *
 * The rows of the contacts take G Z and G z0 in place of G E_Q. A singular Q is Painleve's
 * paradox: the friction that a slide calls for feeds the normal force without bound. */
#ifndef NSDAE_SLIDES_H
#define NSDAE_SLIDES_H

#include <math.h>

#include "contacts.h"

#define NSDAE_BOUND_FIRST   10.0
#define NSDAE_BOUND_FURTHER 1e3
/* A joint as a contact, see cones.h: its limit costs no digits, but squares of it have a bound. */
#define NSDAE_BOUND_CONE 1e10

/* Rows of the j-th slide: one if mu > 0, and two if its direction is not known. */
int nsdae_slides_rows(const nsdae_contacts *contacts, int j);

/* Solves the whole problem, with impulses and modes of the joints into the results; lambda [m] are
 * the multipliers without contacts and friction. Status of nsdae_contacts_solve_lcp, or NSDAE_E_LCP
 * where Q is singular. */
int nsdae_slides_solve(nsdae_contacts *contacts, const double *lambda);

/* A solver of the problem with these limits of the joints, which writes their impulses; and by it
 * the problem with its bounds, of which the first has `times` for NSDAE_BOUND_FIRST. */
typedef int nsdae_slides_solver(nsdae_contacts *contacts, const double *lambda);
int nsdae_slides_limited(nsdae_contacts *contacts, const double *lambda, double times,
                         nsdae_slides_solver *solve);

/* The diagonal entry d of the normal row of a joint as a contact, see cones.h. */
static inline double nsdae_slides_normal(double diagonal, double limit, double fastest)
{
  return diagonal * limit > fastest && fastest > 0 ? fastest / limit : diagonal;
}

/* Of the j-th joint of the problem. */
static inline nsdae_joint_row nsdae_slides_beside(const nsdae_contacts *c, int j)
{
  return c->slides.beside ? c->slides.beside[c->slides.number[j]] : (nsdae_joint_row){0, 0, 1};
}

/* Its bound in the units of its column. */
static inline double nsdae_slides_bound(const nsdae_contacts *c, int j)
{
  return c->slides.bound ? c->slides.bound[c->slides.number[j]] / nsdae_slides_beside(c, j).scale
                         : 0;
}

/* The limit of a problem for a bound: most, unless the bound is less or nothing moves. */
static inline double nsdae_slides_limit(double bound, double most)
{
  return most < bound && (most > 0 || isinf(bound)) ? most : bound;
}

/* Joints with mu > 0. */
int nsdae_slides_loaded(const nsdae_contacts *contacts);

#endif
