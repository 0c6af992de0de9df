#include "separating_axis.h"

void nsdae_half_edges(const nsdae_solid_of *s, double half[3])
{
  for (int i = 0; i < 3; i++) half[i] = i == 2 || s->shape == NSDAE_SHAPE_BOX ? s->half[i] : 0;
}

/* Each solid in the frame of the other. */
static void relate(const nsdae_couple *two, nsdae_separating_axis *o)
{
  double axes[2][9], at[2][3], apart[3];
  for (int s = 0; s < 2; s++) {
    const nsdae_solid_of *solid = two->solid[s];
    for (int i = 0; i < 3; i++) nsdae_turn(two->pose[s]->R, solid->R + 3 * i, axes[s] + 3 * i);
    nsdae_pose_put(two->pose[s], solid->origin, at[s]);
  }
  for (int i = 0; i < 3; i++) apart[i] = at[1][i] - at[0][i];
  for (int i = 0; i < 3; i++) {
    o->way[0][i] = nsdae_dot3(axes[0] + 3 * i, apart);
    o->way[1][i] = -nsdae_dot3(axes[1] + 3 * i, apart);
    for (int j = 0; j < 3; j++) o->cosine[3 * j + i] = nsdae_dot3(axes[0] + 3 * i, axes[1] + 3 * j);
  }
}

/* The best separation along a face's normal of solid s, whose axis i and axis j of the other have
 * the cosine of [i across + j along]. */
static void separate_faces(nsdae_separating_axis *o, int s, const double *half, const double *other)
{
  int across = s ? 3 : 1, along = s ? 1 : 3;
  for (int i = 0; i < 3; i++) {
    const double *way = o->way[s], *c = o->cosine + i * across;
    double apart = fabs(way[i]) - half[i] - other[0] * fabs(c[0]) - other[1] * fabs(c[along]) -
                   other[2] * fabs(c[2 * along]);
    if (!(apart > o->face[s])) continue;
    o->face[s] = apart;
    o->axis[s] = i;
    o->side[s] = way[i] < 0 ? -1 : 1;
  }
}

/* Along axis i of solid 0 x axis j of solid 1, m = e_i x c_j with c_j = (cosines of j); of another
 * axis c_l of solid 1  |m . c_l| = |e_i . (c_j x c_l)|, the cosine of i and the third. Edges nearer
 * to parallel than 1e-8 give no axis that faces do not. They touch by their corners as well: there
 * these are as near up to 1e-8 of their length, and of places eight digits are left. */
static double separate_edges(nsdae_separating_axis *o, int i, int j, double half[2][3])
{
  const double *c = o->cosine + 3 * j, *way = o->way[0], parallel = 1e-16;
  int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
  double square = c[p] * c[p] + c[q] * c[q], along = c[p] * way[q] - c[q] * way[p];
  o->scale[3 * i + j] = 0;
  if (square < parallel) return -INFINITY;
  double reach = half[0][p] * fabs(c[q]) + half[0][q] * fabs(c[p]) +
                 half[1][r] * fabs(o->cosine[3 * s + i]) + half[1][s] * fabs(o->cosine[3 * r + i]);
  double scale = 1 / sqrt(square);
  o->scale[3 * i + j] = along < 0 ? -scale : scale;
  return (fabs(along) - reach) * scale;
}

int nsdae_find_separating_axis(const nsdae_couple *two, double enough, nsdae_separating_axis *o)
{
  const nsdae_solid_of *const *solid = two->solid;
  double half[2][3], size = solid[0]->size + solid[1]->size;
  int from[2];
  relate(two, o);
  o->slack = NSDAE_SLACK * size;
  o->beside = NSDAE_BESIDE * size;
  for (int s = 0; s < 2; s++) {
    nsdae_half_edges(solid[s], half[s]);
    from[s] = solid[s]->shape == NSDAE_SHAPE_BOX ? 0 : 2;
    o->face[s] = -INFINITY;
  }
  for (int s = 0; s < 2; s++) {
    if (from[s] == 0) separate_faces(o, s, half[s], half[1 - s]);
    if (o->face[s] > enough) return 0;
  }
  o->most = nsdae_more_of(o->face[0], o->face[1]);
  for (int i = from[0]; i < 3; i++)
    for (int j = from[1]; j < 3; j++) {
      double apart = separate_edges(o, i, j, half);
      if (apart > enough) return 0;
      o->edges[3 * i + j] = apart;
      o->most = nsdae_more_of(o->most, apart);
    }
  return 1;
}
