/* Spheres in a box, layer in the hollows of layer, that settle: every one rests on four, each
 * contact has friction. For a peer to be timed on in the same run. */
#ifndef NSDAE_BENCH_HEAPS_RIVAL_H
#define NSDAE_BENCH_HEAPS_RIVAL_H

typedef struct packing {
  int side, layers;                 /* spheres along an edge of the even layers; layers */
  double radius, mass, mu, gravity; /* m, kg, -, m/s^2 */
  double dt;                        /* s */
  int settle, steps;                /* before the clock; timed, one by one */
} packing;

/* Where a layer begins, and all: even ones have side^2 spheres, odd ones (side - 1)^2. */
static inline int packing_count(const packing *p, int layers)
{
  int even = (layers + 1) / 2, odd = layers / 2;
  return even * p->side * p->side + odd * (p->side - 1) * (p->side - 1);
}

/* Distance of neighbours in a layer [m]: they do not touch, so that layers carry one another. */
static inline double packing_pitch(const packing *p)
{
  return 2.02 * p->radius;
}

/* Inner edge of the box, on the origin, floor z = 0 [m]. */
static inline double packing_box(const packing *p)
{
  return (p->side - 1) * packing_pitch(p) + 2.01 * p->radius;
}

/* Centre of sphere i of the layer: layers are 1.41 radii apart where they touch, a hundredth of a
 * radius more at the start. */
static inline void packing_place(const packing *p, int layer, int i, double *at)
{
  int side = p->side - layer % 2;
  at[0] = (i % side - (side - 1) / 2.0) * packing_pitch(p);
  at[1] = (i / side - (side - 1) / 2.0) * packing_pitch(p);
  at[2] = p->radius * (1.005 + layer * 1.415);
}

/* Median time of a step [s], and the contacts of the last one; negative where the peer is not built
 * or failed. */
double mujoco_packing(const packing *p, int *contacts);

#endif
