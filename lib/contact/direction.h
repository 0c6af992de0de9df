/* Directions of sliding. */
#ifndef NSDAE_DIRECTION_H
#define NSDAE_DIRECTION_H

/* d [2]: the unit vector u / |u| of u = v_T, but along the direction `last` at least `slow`: it
 * goes smoothly through a stop. Where base is not NULL, linear around it: with u of base and du =
 * v_T - base, u / |u| + (1 - d d^T) du / |u|. */
void nsdae_direction_ahead(const double *last, double slow, const double *v_t, const double *base,
                           double *d);

/* direction [nt] := -force / |force|, or 0. */
void nsdae_direction_against(double *direction, int nt, const double *force);

#endif
