/* Disks in a plane that fall on a floor between two walls and roll there: a system by blocks of
 * three, whose contacts come by list from a grid of cells. */
#ifndef NSDAE_TESTS_DISKS_H
#define NSDAE_TESTS_DISKS_H

#include <nsdae/nsdae.h>

typedef struct disks {
  int n, columns;             /* so many beside each other at the start, the others above them */
  double radius, mass, mu, e; /* [m], [kg], 1, 1 */
  double width;               /* between the walls, at x = 0 and there [m] */
  int cells[2];               /* of a grid over x and y */
  int *first, *next;          /* lists of the disks in each cell */
} disks;

/* Radii of 0.05 m, 1 kg, mu = 0.4, e = 0.3. */
void disks_create(disks *d, int n, int columns);
void disks_destroy(disks *d);

/* q = x, y, theta of each in turn; bodies "disk <i>", a floor and two walls. */
nsdae_system *disks_system(disks *d);
void disks_start(const disks *d, double *q0, double *v0);

/* The id of a contact of disks i < j; of disk i with the floor, the left and the right wall: 0,
 * 1, 2. */
long disks_pair_id(const disks *d, int i, int j);
long disks_ground_id(const disks *d, int i, int which);

#endif
