#include "arms.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "system_impl.h"

/* That of one contact. */
static nsdae_contact_directions one(const nsdae_arms *arms, int i)
{
  nsdae_contact_directions c = arms->all;
  size_t column = (size_t)i * (size_t)c.nv;
  c.normal += column;
  c.other += column;
  c.tangent += column;
  return c;
}

/* v^T H v of contact i: the even part of g'' along v, without what moves by itself. */
static int find_bend(nsdae_arms *arms, int i, double *bend)
{
  const nsdae_system *s = arms->all.system;
  double *second = arms->bend, *sum = arms->bend + s->dims.k;
  static const double weight[] = {0.5, 0.5, -1}, times[] = {1, -1, 0};
  memset(sum, 0, (size_t)s->dims.k * sizeof *sum);
  for (int part = 0; part < 3; part++) {
    for (int j = 0; j < arms->all.nv; j++) arms->v[j] *= times[part];
    int code = nsdae_differences_second(arms->differences, s->call.gap, s->dims.k, arms->t, arms->q,
                                        arms->v, second);
    if (code) return code;
    sum[i] += weight[part] * second[i];
  }
  *bend = sum[i];
  return 0;
}

/* v = e_j - a n - b t, of the translations of velocity `of`. */
static void turn_about(nsdae_arms *arms, const nsdae_contact_directions *c, int of, int j,
                       double tol)
{
  for (int i = 0; i < c->nv; i++)
    arms->v[i] = nsdae_tangent_translates(c, of, i, tol)
                     ? -c->normal[j] * c->normal[i] - c->tangent[j] * c->tangent[i]
                     : 0;
  arms->v[j] = 1;
}

/* n x t, of two translations. */
static double turns(const nsdae_contact_directions *c, int of, double tol)
{
  int second = of + 1;
  while (second < c->nv && !nsdae_tangent_translates(c, of, second, tol)) second++;
  if (second == c->nv) return 0;
  return c->normal[of] * c->tangent[second] - c->normal[second] * c->tangent[of];
}

static int free_alone(const nsdae_contact_directions *c, int j)
{
  for (int i = 0; i < c->nv; i++)
    if (i != j && (c->M[i * c->nv + j] != 0 || c->M[j * c->nv + i] != 0)) return 0;
  return 1;
}

/* What the contacts of one body and one of its rotations said so far. */
typedef struct sense {
  double sign;
  int contact;
} sense;

static int doubt_one(nsdae_arms *arms, int i, int of, int j, double tol, sense *seen, char *text,
                     size_t size)
{
  const nsdae_contact_directions c = one(arms, i);
  char contact[NSDAE_CALLED_SIZE], velocity[NSDAE_CALLED_SIZE], other[NSDAE_CALLED_SIZE];
  double bend, b = c.tangent[j], sign = turns(&c, of, tol) * b;
  turn_about(arms, &c, of, j, tol);
  int code = find_bend(arms, i, &bend);
  if (code) return code;
  nsdae_system_called(c.system, NSDAE_NAME_CONTACT, i, contact);
  nsdae_system_called(c.system, NSDAE_NAME_VELOCITY, j, velocity);
  if (bend > fabs(b) + 100 * tol * (1 + fabs(bend))) {
    snprintf(
        text, size,
        "gap_tangent: its arm %.4g of %s along %s, if that turns the body: it should be %.4g or "
        "more, for turning about the contact opens the gap",
        b, contact, velocity, bend);
  } else if (bend > -fabs(b) * (1 - 1e-3) && fabs(b) > tol) {
    if (seen->sign * sign < 0)
      snprintf(text, size,
               "gap_tangent: the sign of its arm of %s along %s, which turns the other way at %s",
               contact, velocity,
               nsdae_system_called(c.system, NSDAE_NAME_CONTACT, seen->contact, other));
    if (seen->sign == 0) *seen = (sense){sign, i};
  }
  return 0;
}

int nsdae_arms_doubt(nsdae_arms *arms, double tol, char *text, size_t size)
{
  const nsdae_system *s = arms->all.system;
  int n = arms->all.nv, code = 0;
  *text = '\0';
  for (int of = 0; of < n; of++)
    for (int j = 0; j < n; j++) {
      sense seen = {0};
      for (int i = 0; i < s->dims.k && code == 0 && !*text; i++) {
        const nsdae_contact_directions c = one(arms, i);
        if (!(s->contact[i].mu > 0) || !free_alone(&c, j)) continue;
        if (!nsdae_tangent_translates(&c, of, of, tol) || nsdae_tangent_translates(&c, of, j, tol))
          continue;
        if (c.tangent[of] == 0 && turns(&c, of, tol) == 0) continue;
        code = doubt_one(arms, i, of, j, tol, &seen, text, size);
      }
    }
  return code;
}
