/* One contact with Coulomb's law, u = D r + q, solved alone. */
#ifndef NSDAE_FRICTION_ONE_CONTACT_H
#define NSDAE_FRICTION_ONE_CONTACT_H

/* A proximal term that leaves fixed points where they are makes singular diagonal blocks regular.
 */
#define NSDAE_FC_PROXIMAL 1e-9

/* D [9], row-major, positive definite, in the frame in which D[5] = D[7] = 0. slip in: a guess at
 * |u_T| / |r_T| of a contact that slides; out: it, zero if it sticks. tol: of |r_T| to mu r_N
 * there, 1e-15 at least. */
void nsdae_fc_solve_contact(const double *D, const double *q, double mu, double tol, double *slip,
                            double *r);

/* Turns D, symmetric, about the normal into that frame; by: cosine and sine of the turn. */
void nsdae_fc_turn_matrix(double *D, double *by);

/* S := the inverse of D + NSDAE_FC_PROXIMAL, its lower triangle by columns; S[0] is NaN if that
 * is not positive definite to rounding. */
void nsdae_fc_invert(const double *D, double *S);

/* x_T into that frame, or back (sign -1). */
static inline void nsdae_fc_turn(const double *by, double sign, double *x)
{
  double held = x[1];
  x[1] = by[0] * held + sign * by[1] * x[2];
  x[2] = by[0] * x[2] - sign * by[1] * held;
}

#endif
