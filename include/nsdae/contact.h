/* nsdae: what contacts do, shared by descriptions, methods and records; contacts by list.
 * BSD-3-Clause. */
#ifndef NSDAE_CONTACT_H
#define NSDAE_CONTACT_H

#include <nsdae/version.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a contact or frictional joint does: nothing, or with which friction. */
enum nsdae_mode { NSDAE_MODE_OPEN = 0, NSDAE_MODE_SLIP = 1, NSDAE_MODE_STICK = 2 };

/* Normal force of a continuous contact (method penalty), over the overlap d and its rate d'. */
enum nsdae_penalty_law {
  NSDAE_PENALTY_HERTZ,               /* K d^n */
  NSDAE_PENALTY_KELVIN_VOIGT,        /* K d + b d' */
  NSDAE_PENALTY_HUNT_CROSSLEY,       /* K d^n (1 + c d'/d'_0), c = 3 (1 - e) / 2 */
  NSDAE_PENALTY_LANKARANI_NIKRAVESH, /* c = 3 (1 - e^2) / 4 */
  NSDAE_PENALTY_FLORES               /* c = 8 (1 - e) / (5 e) */
};

enum { NSDAE_CONTACT_WIDTH = 6 }; /* velocities of a rigid body */

/* A contact by list: two blocks of v, or a block and the ground, that touch or may. Of its
 * directions the normal comes first, then the dims.nt tangential ones; what is past them is not
 * read. Those of a pair should follow it smoothly: a step begins with the impulses that the one
 * before had along them. Begin with zeros, and set both blocks. */
typedef struct nsdae_contact {
  long id;             /* the same pair of features has the same at all times, no two in a list the
                          same one: warm starts, impacts and records go by it */
  int block[2];        /* 0 .. blocks - 1, or -1: the ground; two different ones */
  double gap;          /* g_N: the distance, negative where they overlap */
  double mu, e_n, e_t; /* friction >= 0 (0 where nt = 0), restitution 0 .. 1, tangential 0 .. 1 */
  double w[3];         /* velocity along each direction with v = 0 */
  double omega[3]; /* acceleration along each with v' = 0; the time-stepping methods need none */
  double direction[2][3][NSDAE_CONTACT_WIDTH]; /* [s][d]: direction d over the velocities of
                          block[s]; the velocity along d is [0][d] . v_0 + [1][d] . v_1 + w[d],
                          which for d = 0 is d g_N / dt. Not read of the ground */
  const double *wide[2];                       /* of a block with more velocities: its directions
                                  [nv x (1 + nt)] in place of direction[s], column-major; else NULL */
} nsdae_contact;

/* The list that a callback fills; it lives as long as the call. */
typedef struct nsdae_contact_list nsdae_contact_list;

/* Adds a copy. NSDAE_OK, also where the list is full: then it grows between steps, and the step is
 * done again. NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE: the contact is refused, and with it the step,
 * whatever the callback returns; the error record of the simulation names the contact and the
 * field. */
NSDAE_API int nsdae_contact_add(nsdae_contact_list *list, const nsdae_contact *contact);

#ifdef __cplusplus
}
#endif

#endif
