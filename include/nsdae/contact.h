/* nsdae: contact modes, contact laws and contact lists. BSD-3-Clause. */
#ifndef NSDAE_CONTACT_H
#define NSDAE_CONTACT_H

#include <nsdae/version.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Mode of a contact or frictional joint: open (frictional joint: frictionless), slip or stick. */
enum nsdae_mode { NSDAE_MODE_OPEN = 0, NSDAE_MODE_SLIP = 1, NSDAE_MODE_STICK = 2 };

/* Normal force of a continuous contact (method penalty), from the overlap d and its rate d'. */
enum nsdae_penalty_law {
  NSDAE_PENALTY_HERTZ,               /* K d^n */
  NSDAE_PENALTY_KELVIN_VOIGT,        /* K d + b d' */
  NSDAE_PENALTY_HUNT_CROSSLEY,       /* K d^n (1 + c d'/d'_0), c = 3 (1 - e) / 2 */
  NSDAE_PENALTY_LANKARANI_NIKRAVESH, /* c = 3 (1 - e^2) / 4 */
  NSDAE_PENALTY_FLORES               /* c = 8 (1 - e) / (5 e) */
};

enum { NSDAE_CONTACT_WIDTH = 6 }; /* velocities of a rigid body */

/* A contact of a contact list: between two blocks of v, or a block and the ground. It may be closed
 * or open. Direction 0 is the normal; directions 1 .. dims.nt are tangential; later ones are
 * ignored. Directions of a pair should change smoothly in time: a step starts from the impulses
 * along the directions of the previous step. Initialise the struct with zeros and set both blocks.
 */
typedef struct nsdae_contact {
  long id;             /* identifies a pair of features at all times, unique in the list; key of
                          warm starts, impacts and records */
  int block[2];        /* 0 .. blocks - 1, or -1 for the ground; two different ones */
  double gap;          /* g_N: distance, negative for an overlap */
  double mu, e_n, e_t; /* friction >= 0 (0 if nt = 0), normal, tangential restitution 0 .. 1 */
  double w[3];         /* velocity along each direction at v = 0 */
  double omega[3];     /* acceleration along each direction at v' = 0, for method event */
  int omega_given;     /* 1: omega is set; 0: it is computed by differences of the velocities of
                          this id */
  double direction[2][3][NSDAE_CONTACT_WIDTH]; /* [s][d]: direction d over the velocities of
                                                  block[s]. Velocity along d: [0][d] . v_0 +
                                                  [1][d] . v_1 + w[d]; for d = 0 it is d g_N /
                                                  dt. Ignored for the ground */
  const double *wide[2];                       /* NULL, or for a block with more velocities: its
                                                  directions [nv x (1 + nt)] in place of
                                                  direction[s], column-major */
} nsdae_contact;

/* The list that a callback fills; valid during the call. */
typedef struct nsdae_contact_list nsdae_contact_list;

/* Adds a copy of a contact.
 *
 * - NSDAE_OK: added, or the list is full. A full list grows between steps, and the step is
 *  repeated.
 * - NSDAE_E_ARGUMENT, NSDAE_E_NONFINITE: the contact is invalid. The step fails, whatever the
 *  callback returns; the error record of the simulation names the contact and the field. */
NSDAE_API int nsdae_contact_add(nsdae_contact_list *list, const nsdae_contact *contact);

#ifdef __cplusplus
}
#endif

#endif
