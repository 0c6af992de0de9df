/* Directions of sliding. */
#ifndef NSDAE_EVENT_SLIP_DIRECTION_H
#define NSDAE_EVENT_SLIP_DIRECTION_H

/* d [2]: the unit vector u / |u| of u = v_T, but along the direction `last` at least `slow`: it
 * goes smoothly through a stop. Its derivative by v_T along l: (1 - d d^T) du / |u|. */
void nsdae_slip_direction_ahead(const double *last, double slow, const double *v_t, double *d);
void nsdae_slip_direction_slope(const double *last, double slow, const double *v_t, int l,
                                double *slope);

/* direction [nt] := -force / |force|, or 0. */
void nsdae_slip_direction_against(double *direction, int nt, const double *force);

#endif
