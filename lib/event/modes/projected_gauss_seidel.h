/* Friction in two directions with the cone itself, from the solution with the polygon around it:
 * projected block Gauss-Seidel (Jean, "The non-smooth contact dynamics method", 1999). With
 * xi = G F + offset, of accelerations or of velocities, in turn for every contact
 *
 *   F_N := max(0, F_N - xi_N / G_NN)
 *   F_T := the point of the disk |F_T| <= mu F_N closest to F_T - xi_T / rho,   rho >= |G_TT|
 *
 * whose fixed points are the solutions: 0 <= F_N _|_ xi_N >= 0, and F_T = -mu F_N xi_T / |xi_T|
 * where xi_T is not zero. A contact that slides already has F_T = -mu F_N d, and moves along
 * W_N - mu W_T d. */
#ifndef NSDAE_EVENT_PROJECTED_GAUSS_SEIDEL_H
#define NSDAE_EVENT_PROJECTED_GAUSS_SEIDEL_H

#include "contacts.h"

/* Brings the solved problem's impulses to the cone, with the direction [k nt] of what slides, and
 * with them v [nv], lambda [m] and the contacts' velocities after. force, xi [columns] are for its
 * work, and the residual of the problem is that of the cones then, up to contact_tol. 1; 0 where it
 * was not found, or there are slides: then all is as before. */
int nsdae_projected_gauss_seidel(nsdae_contacts *contacts, const double *direction, double *force,
                                 double *xi, double *v, double *lambda);

/* The same from no impulse on, with v and lambda without any: where the problem was not solved, or
 * its contacts are pressed. The modes are then for the cones to say. Where it was not found the
 * problem's impulses are gone. */
int nsdae_projected_gauss_seidel_anew(nsdae_contacts *contacts, const double *direction,
                                      double *force, double *xi, double *v, double *lambda);

/* Whether the solution presses bodies against each other out of all proportion, which a problem
 * near one without a solution allows. */
int nsdae_contacts_pressed(const nsdae_contacts *contacts);

#endif
