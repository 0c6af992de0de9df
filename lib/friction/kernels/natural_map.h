/* Equations that hold where an item obeys its law, and their derivatives: as they are, and
 * smoothed.
 *
 *   0 = r - P(r - u^),   u^ = u + mu |u_T| e_N
 *
 * P the projection onto the cone (natural map). With G its derivative and N = 1 + mu e_N t^T, t the
 * direction of slip, the derivatives are  B = 1 - G in r  and  A = G N  in u. */
#ifndef NSDAE_FRICTION_NATURAL_MAP_H
#define NSDAE_FRICTION_NATURAL_MAP_H

/* F [3] at r + low, u [3] (low NULL: at r); B and A [9], row-major; kind as in cone.h. */
void nsdae_fc_natural_map(int kind, double mu, const double *r, const double *low, const double *u,
                          double *F, double *B, double *A);

/* The same of a smooth neighbour: eigenvalues l of r - u^ become (l + sqrt(l^2 + 4 e^2)) / 2 in
 * place of max(0, l) (Chen, Harker, Kanzow, Smale; of second-order cones: Fukushima, Luo, Tseng,
 * SIAM J. Optim. 12 (2002) 436), and |u_T| to sqrt(|u_T|^2 + e^2) - e. Its root has r inside the
 * cone, u^ inside the dual cone and r o u^ = e^2: the central path of an interior point, met from
 * anywhere. */
void nsdae_fc_smooth_map(int kind, double mu, double epsilon, const double *r, const double *u,
                         double *F, double *B, double *A);

#endif
