/* Judges every point before it becomes the state: what the method does not explain is reported,
 * once for each kind. docs/methods/warnings.md has the bounds and where they come from. In its
 * letters h is the step, c the largest entry of Phi_q at the start, l = max h c max |v_j| the way
 * along such a row in one step so far, g the largest change of a gap in one; neither is below the
 * way h^2 F / M that the forces of the start lead to from rest. */
#ifndef NSDAE_MONITORS_H
#define NSDAE_MONITORS_H

/* Bits of nsdae_stats.warnings, in the order in which they are said. */
enum {
  NSDAE_MONITORS_ENERGY = 1,
  NSDAE_MONITORS_PENETRATION = 2,
  NSDAE_MONITORS_DRIFT = 4,
  NSDAE_MONITORS_PAINLEVE = 8,
  NSDAE_MONITORS_IMPACTS = 16,
  NSDAE_MONITORS_RESTITUTION = 32
};

/* What is kept of the run so far: doubles alone, see snapshot.c. */
typedef struct nsdae_monitors {
  double change;   /* g */
  double row, way; /* c, l */
  double apart;    /* the largest gap so far; 0: all were closed at the start */
  double scale;    /* largest kinetic energy so far */
  double known;    /* the largest that came from somewhere */
  double kinetic;  /* of the start */
} nsdae_monitors;

#endif
