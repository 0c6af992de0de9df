/* Looks at every point before it becomes the state: a record with a value that is not finite is
 * refused, and what the method does not explain is said.
 *
 * What a method explains. Let h be the step, c a row of Phi_q or W_N, and l = max h sum |c_j v_j|,
 * the longest way that a point of the mechanism went along such a row in one step so far.
 *
 * Penetration: a contact is found closed at the end (moreau: the middle) of a step, so a gap falls
 *   below zero by at most what it changed in a step, and no impulse pulls it apart again: what
 * comes later keeps v_N >= 0 to first order and adds the bend of the surface, h^2 v' W_q v / 2 a
 * step. More than 4 times the largest change of a gap in a step is not that. Drift: one
 * step violates a constraint by O(h^3), moreau by O(h^2), of the way l of that step. What
 *   accumulates to more than 4 l is no longer a position on the constraint.
 * Energy: with v(+) + v(-) = 2 vm, contact impulses do the work  Lambda_N vm_N + Lambda_T vm_T.
 * Newton's law gives Lambda_N (1 - e) v_N(-) / 2 <= 0 for a contact that closes, Coulomb's Lambda_T
 * v_T(+) <= 0; what the other half of the tangential work, Lambda_T v_T(-) / 2, or a contact that
 * was opening, brings is a gain of the law (Kane's paradox): the sum of all steps that gained. And
 * a time-stepping method moves by its own quadrature of the forces: the kinetic energy that came
 * and is neither
 *
 *     sum h/2 (F_0 v_0 + F_1 v_1) + vm^T (M_1 - M_0) vm / 2,  nor Lambda Phi_t, nor -Lambda_c w,
 * nor the work of contacts
 *
 *   is its error (the second term: T = v^T M v / 2 changes with M, too). Gains of more than
 * WATCH_GAIN of the largest kinetic energy so far are said. penalty and event control the error of
 * the smooth motion; of them contact work alone is looked at. */
#ifndef NSDAE_WATCH_H
#define NSDAE_WATCH_H

/* Bits of nsdae_stats.warnings, in the order in which they are said. */
enum { NSDAE_WATCH_ENERGY = 1, NSDAE_WATCH_PENETRATION = 2, NSDAE_WATCH_DRIFT = 4 };

/* What is kept of the run so far. */
typedef struct nsdae_watch {
  double change;  /* largest change of a gap in a step */
  double way;     /* l */
  double scale;   /* largest kinetic energy and work so far */
  double kinetic; /* of the start */
  double t;       /* up to here the work is summed, one step behind */
  double power;   /* F v there */
  double work;    /* of forces, moving constraints and moving contacts */
  double turned;  /* of inertia in the last step, not summed yet */
  double gained;  /* by contact impulses */
} nsdae_watch;

#endif
