/* Directions of friction, as far as the gap and the mass matrix tell what they must be. */
#ifndef NSDAE_SYSTEM_TANGENTS_H
#define NSDAE_SYSTEM_TANGENTS_H

struct nsdae_system;

/* set [nv]: of the velocities that move alike, nt + 1 of one mass without coupling and not of
 * different units, which may be the translations of one body, the first; of others one of these.
 * mass [nv]: 0 if M couples the velocity with others or changes. */
enum { NSDAE_TANGENT_COUPLED = -1, NSDAE_TANGENT_ALONE = -2 };
void nsdae_tangent_sets(const struct nsdae_system *system, const double *mass, int *set);

/* Of one contact. */
typedef struct nsdae_contact_directions {
  const struct nsdae_system *system; /* for names */
  int nv, nt;
  const int *set;               /* nv: see nsdae_tangent_sets */
  const double *normal, *other; /* nv: its column of W_N here, and at another place */
  const double *tangent;        /* nv x nt: its directions */
} nsdae_contact_directions;

/* Contact i of those whose columns are one behind the other. */
nsdae_contact_directions nsdae_tangent_contact(const nsdae_contact_directions *all, int i);

/* Whether anything is wrong with direction j < nt, and what, as text. tol: of what differences
 * give. */
enum { NSDAE_TANGENT_TEXT = 200 };
int nsdae_tangent_wrong(const nsdae_contact_directions *contact, int j, double tol,
                        char why[NSDAE_TANGENT_TEXT]);

/* The same of what no body can rub along: zero, the normal, one twice; `other` is not looked at. */
int nsdae_tangent_useless(const nsdae_contact_directions *contact, int j, double tol,
                          char why[NSDAE_TANGENT_TEXT]);

/* Whether the gap has a gradient of one length that is not 1, here and elsewhere, along velocities
 * that may be the translations of one body, and what then. */
int nsdae_gap_scaled(const nsdae_contact_directions *contact, double tol,
                     char why[NSDAE_TANGENT_TEXT]);

/* Whether velocities i and j are two of those that translate one body, and i is the first. */
int nsdae_tangent_translates(const nsdae_contact_directions *contact, int i, int j, double tol);

#endif
