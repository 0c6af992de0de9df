/* Nothing but W_T itself says where a contact slides to. But the translations of a body that is
 * free in M are known there: two velocities, in space three, and no others, with one mass m and no
 * coupling,
 *
 *   T = m |x'|^2 / 2 + ...,
 *
 * where the part of W_N along them has length one, here and elsewhere: a distance has
 * g' = n . x' + (r x n) . w with |n| = 1 everywhere, while arms r change with q. The slip is
 * v_T = t . x' + (r x t) . w: the parts of the directions t along them have length one, too, and
 * are at right angles to n and to each other; or they are zero, where other bodies slide. Of two
 * bodies that touch each other, n and -n, they are opposite. For the parts of rotations see
 * moment_arms.h.
 */
#include "tangent_check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "system_impl.h"

typedef nsdae_contact_directions directions;

enum { COUPLED = NSDAE_TANGENT_COUPLED, ALONE = NSDAE_TANGENT_ALONE, UNDECIDED = -3 };

static int same_mass(const nsdae_system *s, const double *mass, const int *set, int i, int j)
{
  if (set[i] == COUPLED || set[j] == COUPLED || mass[i] != mass[j]) return 0;
  const char *a = nsdae_system_get_unit(s, NSDAE_NAME_VELOCITY, i),
             *b = nsdae_system_get_unit(s, NSDAE_NAME_VELOCITY, j);
  return !*a || !*b || strcmp(a, b) == 0;
}

void nsdae_tangent_sets(const nsdae_system *s, const double *mass, int *set)
{
  int n = s->dims.nv, nt = s->dims.nt;
  for (int i = 0; i < n; i++) set[i] = mass[i] > 0 ? UNDECIDED : COUPLED;
  /* The coordinates that move as `first` does: all of that mass where they are as many as there are
   * directions, or else, of bodies that are alike, those that stand side by side. */
  for (int first = 0; first < n; first++) {
    int all = 0, end = first, count = 0;
    if (set[first] != UNDECIDED) continue;
    for (int i = 0; i < n; i++) all += same_mass(s, mass, set, first, i);
    while (end < n && same_mass(s, mass, set, first, end)) end++;
    if (all == nt + 1) end = n;
    for (int i = first; i < end; i++) count += same_mass(s, mass, set, first, i);
    for (int i = end - 1; i >= first; i--)
      if (same_mass(s, mass, set, first, i)) set[i] = count == nt + 1 ? first : ALONE;
  }
}

directions nsdae_tangent_contact(const directions *all, int i)
{
  directions c = *all;
  size_t column = (size_t)i * (size_t)c.nv;
  c.normal += column;
  c.other += column;
  c.tangent += column * (size_t)c.nt;
  return c;
}

static int together(const directions *c, int of, int i)
{
  return c->set[of] >= 0 && c->set[i] == c->set[of];
}

/* The product of two columns along the set of velocity `of`. */
static double along(const directions *c, int of, const double *a, const double *b)
{
  double sum = 0;
  for (int i = 0; i < c->nv; i++)
    if (together(c, of, i)) sum += a[i] * b[i];
  return sum;
}

/* Whether velocity `of` is the first of a set that translates a body, as the normal shows. */
static int translates(const directions *c, int of, double tol)
{
  return c->set[of] == of && fabs(along(c, of, c->normal, c->normal) - 1) <= tol &&
         fabs(along(c, of, c->other, c->other) - 1) <= tol;
}

int nsdae_tangent_translates(const directions *c, int i, int j, double tol)
{
  return translates(c, i, tol) && together(c, i, j);
}

/* max |a_i + a_j| over velocities i of the set of `of` and j of that of `to`, in their order */
static double sum_of(const directions *c, int of, int to, const double *a)
{
  double most = 0;
  for (int i = of, j = to; i < c->nv && j < c->nv; i++, j++) {
    while (i < c->nv && !together(c, of, i)) i++;
    while (j < c->nv && !together(c, to, j)) j++;
    if (i < c->nv && j < c->nv) most = fmax(most, fabs(a[i] + a[j]));
  }
  return most;
}

/* Two bodies that move alike keep their gap where they touch each other, here and elsewhere: then
 * they do not slip either, and what the one feels the other feels against it. */
static int wrong_between(const directions *c, int of, int j, double tol, char *why)
{
  const double *t = c->tangent + (size_t)j * (size_t)c->nv;
  char a[NSDAE_CALLED_SIZE], b[NSDAE_CALLED_SIZE];
  for (int to = of + 1; to < c->nv; to++) {
    if (!translates(c, to, tol) || along(c, of, t, t) == 0 || along(c, to, t, t) == 0) continue;
    if (sum_of(c, of, to, c->normal) > tol || sum_of(c, of, to, c->other) > tol) continue;
    if (sum_of(c, of, to, t) <= tol) continue;
    return snprintf(why, NSDAE_TANGENT_TEXT,
                    "is not opposite on the two bodies that %s and %s move, as the normal is: a "
                    "common translation is no slip",
                    nsdae_system_called(c->system, NSDAE_NAME_VELOCITY, of, a),
                    nsdae_system_called(c->system, NSDAE_NAME_VELOCITY, to, b));
  }
  return 0;
}

/* By the set of velocity `of`. */
static int wrong_along(const directions *c, int of, int j, double tol, char *why)
{
  static const char *const where = "along the translations of the body that";
  char called[NSDAE_CALLED_SIZE];
  const char *velocity = nsdae_system_called(c->system, NSDAE_NAME_VELOCITY, of, called);
  const double *t = c->tangent + (size_t)j * (size_t)c->nv;
  double squared = along(c, of, t, t), across = along(c, of, t, c->normal);
  double both = j > 0 ? along(c, of, t, t - c->nv) : 0;
  if (squared == 0) return 0;
  if (fabs(squared - 1) > tol)
    return snprintf(why, NSDAE_TANGENT_TEXT,
                    "has length %.6g %s %s moves: it must be a unit vector, like the normal",
                    sqrt(squared), where, velocity);
  if (fabs(across) > tol)
    return snprintf(why, NSDAE_TANGENT_TEXT, "is not perpendicular to the normal: %.3g %s %s moves",
                    across, where, velocity);
  if (fabs(both) <= tol) return wrong_between(c, of, j, tol, why);
  return snprintf(why, NSDAE_TANGENT_TEXT,
                  "is not perpendicular to the one before it: %.3g %s %s moves", both, where,
                  velocity);
}

/* The same up to tol, the rounding of differences, and up to the sign. */
static int near_column(int n, const double *a, const double *b, double tol)
{
  double plus = 0, minus = 0;
  for (int i = 0; i < n; i++) {
    plus = fmax(plus, fabs(a[i] - b[i]));
    minus = fmax(minus, fabs(a[i] + b[i]));
  }
  return fmin(plus, minus) <= tol;
}

/* Two sets that the normal has unit parts along are of two bodies that touch each other, and its
 * parts are opposite; or else at least one of them, such as rotations whose arms are one long, is
 * no set of translations. */
static int contradicted(const directions *c, int of, double tol)
{
  for (int to = 0; to < c->nv; to++)
    if (to != of && translates(c, to, tol) && sum_of(c, of, to, c->normal) > tol) return 1;
  return 0;
}

int nsdae_tangent_useless(const directions *c, int j, double tol, char why[NSDAE_TANGENT_TEXT])
{
  int n = c->nv, row = 0, none = 0; /* none: without a normal it is no contact here */
  const double *t = c->tangent + (size_t)j * (size_t)n;
  while (row < n && t[row] == 0) row++;
  while (none < n && c->normal[none] == 0) none++;
  if (row == n && none == n) return 0;
  if (row == n)
    return snprintf(why, NSDAE_TANGENT_TEXT, "is zero: it must be a tangential direction");
  if (n > 1 && near_column(n, t, c->normal, tol))
    return snprintf(why, NSDAE_TANGENT_TEXT,
                    "is equal to the normal (gap_normal): it must be a tangential direction");
  if (j > 0 && n > 1 && near_column(n, t, t - n, 0))
    return snprintf(why, NSDAE_TANGENT_TEXT,
                    "is equal to the one before it: the two must be perpendicular");
  return 0;
}

int nsdae_tangent_wrong(const nsdae_contact_directions *c, int j, double tol,
                        char why[NSDAE_TANGENT_TEXT])
{
  if (nsdae_tangent_useless(c, j, tol, why)) return 1;
  for (int i = 0; i < c->nv; i++)
    if (translates(c, i, tol) && !contradicted(c, i, tol) && wrong_along(c, i, j, tol, why))
      return 1;
  return 0;
}

/* Directions as long as the normal: a gap and its W_T that are scaled alike are the same contact,
 * with other impulses. */
static int scaled_alike(const directions *c, int of, double length, double tol)
{
  for (int j = 0; j < c->nt; j++) {
    const double *t = c->tangent + (size_t)j * (size_t)c->nv;
    if (fabs(sqrt(along(c, of, t, t)) - length) > tol * length) return 0;
  }
  return 1;
}

int nsdae_gap_scaled(const directions *c, double tol, char why[NSDAE_TANGENT_TEXT])
{
  char called[NSDAE_CALLED_SIZE];
  for (int of = 0; of < c->nv; of++) /* as long as one body says: others are no translations, as */
    if (translates(c, of, tol)) return 0; /* small rotations, whose arms do not change */
  for (int of = 0; of < c->nv; of++) {
    if (c->set[of] != of) continue;
    double here = sqrt(along(c, of, c->normal, c->normal));
    double there = sqrt(along(c, of, c->other, c->other));
    if (!(here > tol) || !(fabs(here - there) <= tol * here)) continue;
    if (fabs(here - 1) <= tol || scaled_alike(c, of, here, tol)) continue;
    return snprintf(why, NSDAE_TANGENT_TEXT,
                    "has a gradient of length %.6g along the velocities of the same mass as %s, "
                    "here and elsewhere: if they translate one body, that of a distance is 1",
                    here, nsdae_system_called(c->system, NSDAE_NAME_VELOCITY, of, called));
  }
  return 0;
}
