/* Disks in the plane that rest on a floor with friction, each by itself, for a peer to be timed on
 * in the same run: three degrees of freedom a disk, one contact. */
#ifndef NSDAE_BENCH_DISKS_RIVAL_H
#define NSDAE_BENCH_DISKS_RIVAL_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct disks {
  int count, steps;
  double radius, mass, gravity, mu, dt; /* m, kg, m/s^2, -, s */
} disks;

/* Time of all steps [s], creation left out; negative where the peer is not built or failed,
 * infinite where it gave a problem up. fastest: the largest velocity at the end [m/s]. */
double siconos_disks(const disks *d, double *fastest);

#ifdef __cplusplus
}
#endif
#endif
