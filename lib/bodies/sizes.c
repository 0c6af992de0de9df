/* Lengths that overlap and drift are measured by (nsdae_system_set_size): of a body, how wide its
 * narrowest solid is; of a constraint, the arm of its points about their bodies' centres, or 1 if
 * it holds an angle. A row that is known up to a period has the size period / (2 pi): of a screw
 * and a rack the displacement per radian. So its drift is bounded before it jumps by a period. */
#include "bodies_impl.h"

/* The least, over the edges of a planar solid or the faces of a polyhedron, of the largest distance
 * of a corner from it. */
static double width_across(const nsdae_solid_of *s)
{
  double least = INFINITY;
  for (int e = 0; e < (s->hull ? s->hull->faces : s->points); e++) {
    const double *n = s->edge + 4 * e;
    const double *from = s->point + 3 * (s->hull ? s->hull->ring[s->hull->first[e]] : e);
    double most = 0;
    for (int i = 0; i < s->points; i++) {
      const double *p = s->point + 3 * i;
      most = fmax(most, nsdae_dot3(n, from) - nsdae_dot3(n, p));
    }
    least = fmin(least, most);
  }
  return least;
}

double nsdae_solid_width(const nsdae_solid_of *s)
{
  double core = 0;
  if (s->shape == NSDAE_SHAPE_PLANE || s->hollow) return INFINITY;
  if (nsdae_solid_is_smooth(s))
    core = 2 * fmin(fmin(s->half[0], s->half[1]), s->half[2] > 0 ? s->half[2] : s->half[0]);
  else if (s->points > 2)
    core = width_across(s);
  return core + 2 * s->radius;
}

/* INFINITY of what has no width, too: a point, a line. */
static double width_of(const nsdae_solid_of *s)
{
  return s->width > 0 ? s->width : INFINITY;
}

/* 0 means that there is none. */
static int set_size(nsdae_system *system, int kind, int i, double size)
{
  return nsdae_system_set_size(system, kind, i, isfinite(size) ? size : 0);
}

int nsdae_bodies_set_sizes(const nsdae_bodies *b, nsdae_system *system)
{
  int status = NSDAE_OK;
  for (int body = 0; nsdae_bodies_has_list(b) && body < b->body.count && status == NSDAE_OK;
       body++) {
    double least = INFINITY;
    for (int i = 0; i < b->solid.count; i++)
      if (nsdae_solid_at(b, i)->body == body) least = fmin(least, width_of(nsdae_solid_at(b, i)));
    status = set_size(system, NSDAE_NAME_CONTACT, body, least);
  }
  for (int i = 0; i < nsdae_bodies_fixed(b) - b->limit.count && status == NSDAE_OK; i++) {
    const int *solid = nsdae_feature_at(b, i)->solid;
    double first = width_of(nsdae_solid_at(b, solid[0]));
    double second = width_of(nsdae_solid_at(b, solid[1]));
    status = set_size(system, NSDAE_NAME_CONTACT, i, fmin(first, second));
  }
  for (int i = 0; i < b->constraint.count && status == NSDAE_OK; i++) {
    const nsdae_bodies_constraint *c = nsdae_constraint_at(b, i);
    const nsdae_primitive *e = &c->value;
    int length = e->kind == NSDAE_PRIMITIVE_DISTANCE;
    int angle = !length && e->kind != NSDAE_PRIMITIVE_ALONG;
    double arm = length ? c->p[0] : angle;
    for (int j = 0; j < 2 && !angle; j++)
      if (e->body[j] != NSDAE_GROUND) arm = fmax(arm, sqrt(nsdae_dot3(e->point[j], e->point[j])));
    if (c->period > 0) arm = c->period / (2 * nsdae_pi);
    status = set_size(system, NSDAE_NAME_CONSTRAINT, i, arm);
  }
  return status;
}
