/* Directions of friction, as far as the gap and the mass matrix tell what they must be. */
#ifndef NSDAE_SYSTEM_TANGENTS_H
#define NSDAE_SYSTEM_TANGENTS_H

/* Of one contact. */
typedef struct nsdae_contact_directions {
  int nv, nt;
  const double *M;              /* nv x nv */
  const double *normal, *other; /* nv: its column of W_N here, and at another place */
  const double *tangent;        /* nv x nt: its directions */
} nsdae_contact_directions;

/* Whether anything is wrong with direction j < nt, and what, as text. tol: of what differences
 * give. */
enum { NSDAE_TANGENT_TEXT = 160 };
int nsdae_tangent_wrong(const nsdae_contact_directions *contact, int j, double tol,
                        char why[NSDAE_TANGENT_TEXT]);

#endif
