#include "separating_axis.h"

/* A box, or a capsule's segment: what is within half of its centre along its three axes in space.
 */
typedef struct core {
  double centre[3], axis[3][3], half[3];
  int faces; /* whether it has any */
} core;

static core core_of(const nsdae_solid_of *s, const nsdae_pose *pose)
{
  core c = {.half = {0, 0, s->half[2]}, .faces = s->shape == NSDAE_SHAPE_BOX};
  nsdae_turn(pose->R, s->origin, c.centre);
  for (int i = 0; i < 3; i++) {
    c.centre[i] += pose->r[i];
    nsdae_turn(pose->R, s->R + 3 * i, c.axis[i]);
    if (c.faces) c.half[i] = s->half[i];
  }
  return c;
}

/* How far a core reaches along a direction from its centre. */
static double reach(const core *c, const double *n)
{
  double sum = 0;
  for (int i = 0; i < 3; i++) sum += c->half[i] * fabs(nsdae_dot3(n, c->axis[i]));
  return sum;
}

/* The best separation along a face's normal of the first. */
static void separate_faces(const core *c, const core *other, const double *apart,
                           nsdae_separating_axis *o)
{
  o->face = -INFINITY;
  for (int i = 0; i < 3 && c->faces; i++) {
    double along = nsdae_dot3(apart, c->axis[i]);
    double s = fabs(along) - c->half[i] - reach(other, c->axis[i]);
    if (!(s > o->face)) continue;
    o->face = s;
    o->axis = i;
    o->side = along < 0 ? -1 : 1;
  }
}

nsdae_separating_axis nsdae_separating_axis_find(const nsdae_couple *two)
{
  core c0 = core_of(two->solid[0], two->pose[0]), c1 = core_of(two->solid[1], two->pose[1]);
  double apart[3], back[3], size = two->solid[0]->size + two->solid[1]->size;
  nsdae_separating_axis o, there;
  for (int i = 0; i < 3; i++) {
    apart[i] = c1.centre[i] - c0.centre[i];
    back[i] = -apart[i];
  }
  separate_faces(&c0, &c1, apart, &o);
  o.slack = NSDAE_SLACK * size;
  o.beside = NSDAE_BESIDE * size;
  o.most = o.face;
  if (o.face > o.slack) return o;
  separate_faces(&c1, &c0, back, &there);
  o.most = fmax(o.face, there.face);
  /* The best separation along a normal of two edges. Those nearer to parallel than 1e-8 give no
   * axis that faces do not. */
  for (int i = c0.faces ? 0 : 2; i < 3; i++)
    for (int j = c1.faces ? 0 : 2; j < 3; j++) {
      double n[3];
      nsdae_cross3(c0.axis[i], c1.axis[j], n);
      double length = sqrt(nsdae_dot3(n, n));
      if (length < 1e-8) continue;
      o.most = fmax(o.most, (fabs(nsdae_dot3(n, apart)) - reach(&c0, n) - reach(&c1, n)) / length);
    }
  return o;
}
