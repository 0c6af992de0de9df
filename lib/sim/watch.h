/* Looks at every point before it becomes the state: a record with a value that is not finite is
 * refused, and what the method does not explain is said.
 *
 * What a method explains. Let h be the step, c the largest entry of Phi_q at the start, l = max h c
 * max |v_j| the way along such a row in one step so far, and g the largest change of a gap
 * in one; neither below the way h^2 F / M that the start's forces lead to from rest.
 *
 * - Penetration: deeper than a quarter of the smaller body, if its width is known. Else a contact
 * is found closed at the end (moreau: the middle) of a step, so a gap falls below zero by at most
 * g. The step of the impact adds (1 - e) g / 2. Later steps keep v_N >= 0; while the normal turns
 * by h v / r a step, Newton's law adds (1 - e) h^2 v^2 / (2 r), half a way for a radian, and
 * implicit-printed, whose normal is that of the begin, one way. A contact that stays closed for a
 * full turn is (3/2 + 2 pi) g deep at most. If some
 * contact was open at the start, no step leads from open to an overlap as large as the largest gap
 * so far: it would be longer than all lengths that are known.
 * With penalty the overlap d stores K d^(n+1) / (n+1), at most what the contact took; a load that
 * is put on suddenly goes to twice the d of rest.
 * - Drift: a step of moreau ends h^2/2 v^T Phi_qq v off, half its way for each radian that the row
 * turns; the others are off by a higher order. More than pi l has added up over a full turn. A
 * tenth of the joint's arm counts where it is known.
 * - Impacts: see merged.c.
 * - Energy: with v(+) + v(-) = 2 vm contact impulses do the work Lambda_N vm_N + Lambda_T vm_T.
 * Newton's law makes Lambda_N (1 - e) v_N(-) / 2 <= 0 of a contact that closes, Coulomb's Lambda_T
 * v_T(+) <= 0. What the other half of the tangential work brings, or a contact that was opening, is
 * a gain of the law (Kane's paradox): the sum of all steps that gained. And a time-stepping method
 * moves by its own quadrature of the forces: the kinetic energy that is neither
 *
 *     sum h/2 (F_0 v_0 + F_1 v_1) + vm^T (M_1 - M_0) vm / 2,  nor Lambda Phi_t,  nor -Lambda_c w,
 *
 *   nor the work of contacts is its error (the second term: T = v^T M v / 2 changes with M, too).
 * Gains are said of more than a tenth of the largest kinetic energy so far and a fiftieth of the
 * turnover sum h/2 |P_0 + P_1|, P = F v, or, as the turnover has no end, of more than half of the
 * largest kinetic energy that came from somewhere (T less what did not), a fiftieth of what
 * contacts did and took, and what the quadrature may have missed: sum h/4 |P_1 - 2 P_0 + P_-1|,
 * three times its error where P is smooth and the error of a jump. To both comes a fiftieth of the
 * work of what moves by itself. Where the forces grow
 * with the square of the velocities steps that are too long run away before this error has a sign:
 * three in a row that multiply the kinetic energy by 100 are said, too (that of constant forces
 * grows fourfold in a second step, of forces that grow with t^2 64-fold). penalty and event
 * control the error of the smooth motion; of them contact work alone is looked at.
 */
#ifndef NSDAE_WATCH_H
#define NSDAE_WATCH_H

/* Bits of nsdae_stats.warnings, in the order in which they are said. */
enum {
  NSDAE_WATCH_ENERGY = 1,
  NSDAE_WATCH_PENETRATION = 2,
  NSDAE_WATCH_DRIFT = 4,
  NSDAE_WATCH_PAINLEVE = 8,
  NSDAE_WATCH_IMPACTS = 16,
  NSDAE_WATCH_RESTITUTION = 32
};

/* What is kept of the run so far: doubles alone, see block.c. */
typedef struct nsdae_watch {
  double change;   /* g */
  double row, way; /* c, l */
  double apart;    /* the largest gap so far; 0: all were closed at the start */
  double scale;    /* largest kinetic energy so far */
  double known;    /* the largest that came from somewhere */
  double kinetic;  /* of the start */
  double t;        /* up to here the work is summed, one step behind */
  double power;    /* F v there, */
  double earlier;  /* and a step before */
  double turnover; /* of forces, its steps' amounts; */
  double unsure;   /* what the quadrature may miss of it */
  double spent;    /* by contacts, amounts; */
  double driven;   /* of what moves by itself, amounts */
  double rounding; /* of the work of forces */
  double gained;   /* by contact impulses */
  double soared;   /* steps in a row that multiplied the kinetic energy */
} nsdae_watch;

#endif
