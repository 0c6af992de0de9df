/* Friction on a bilateral constraint, such as a slider in a slot without play.
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
 *   l- = K x + k0,   Lambda = Z x + z0,   Z = Z_b - mu K,   z0 = -mu k0     (on the frictional
 * joints) l- row: K;   xi_R row: W_S^T P W Z + [xi_L];   Lambda_L row: 2 mu (S + K) - [Lambda_R]
 *
 * Where the direction of sliding s = +-1 is known, l+ is the only row left, its complement l-, and
 * Lambda_T = -s mu (l+ + l-): s mu takes the place of mu, and Lambda_R and xi_L are left out.
 *
 * The rows of the contacts take G Z and G z0 in place of G E_Q. A singular Q is Painleve's
 * paradox: the friction that a slide calls for feeds the normal force without bound. */
#ifndef NSDAE_SLIDES_H
#define NSDAE_SLIDES_H

#include "contacts.h"

/* Rows of the j-th slide: three, or one where its direction is known. */
int nsdae_slides_rows(const nsdae_contacts *contacts, int j);

/* A and b of the whole problem; lambda [m] are the multipliers without contacts and friction.
 * NSDAE_OK, or NSDAE_E_LCP where Q is singular. */
int nsdae_slides_assemble(nsdae_contacts *contacts, const double *lambda);

/* enum nsdae_mode and friction of the frictional joints from the solution. */
void nsdae_slides_scatter(nsdae_contacts *contacts);

#endif
