#include "moment_arms.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "system_impl.h"

int nsdae_moment_arms_bend(nsdae_moment_arms *arms, int i, double *bend)
{
  const nsdae_system *s = arms->all.system;
  int code = nsdae_differences_bend(arms->differences, s->call.gap, s->dims.k, arms->t, arms->q,
                                    arms->v, arms->bend);
  *bend = arms->bend[i];
  return code;
}

int nsdae_moment_arms_bends(nsdae_moment_arms *arms, int i, double bend, double tol, int *bends)
{
  double finer = NAN;
  arms->differences->finer[1] = 1;
  int code = nsdae_moment_arms_bend(arms, i, &finer);
  arms->differences->finer[1] = 0;
  *bends = fabs(finer - bend) <= tol;
  return code;
}

/* n x t, of two translations. */
static double turns(const nsdae_contact_directions *c, int of, double tol)
{
  int second = of + 1;
  while (second < c->nv && !nsdae_tangent_translates(c, of, second, tol)) second++;
  if (second == c->nv) return 0;
  return c->normal[of] * c->tangent[second] - c->normal[second] * c->tangent[of];
}

/* Rates along arms->v: of b, and how fast n turns towards t. */
typedef struct turning {
  double arm, normal;
} turning;

/* Adds those of one side, of displacement and weight +-s. */
static int add_side(nsdae_moment_arms *arms, const nsdae_contact_directions *c, int i, int of,
                    int j, double s, double tol, turning *sum)
{
  nsdae_differences *d = arms->differences;
  const nsdae_system *system = c->system;
  int n = c->nv;
  double *along = arms->bend + system->dims.k;
  for (int l = 0; l < system->dims.nq; l++) d->moved[l] = arms->q[l] + s * arms->rate[l];
  memset(d->W, 0, (size_t)n * (size_t)system->dims.k * sizeof *d->W);
  int code = system->call.gap_tangent(arms->t, d->moved, d->W, n, system->user);
  if (code) d->failed = "gap_tangent";
  sum->arm += d->W[(size_t)i * (size_t)n + (size_t)j] / (2 * s);
  if (code) return code;
  /* t . n at d->moved, t the translations of the direction here: the rate of gap i along them */
  for (int l = 0; l < n; l++)
    along[l] = nsdae_tangent_translates(c, of, l, tol) ? c->tangent[l] : 0;
  code = nsdae_differences_along(d, system->call.gap, system->dims.k, arms->t, d->moved, along,
                                 arms->bend);
  sum->normal += arms->bend[i] / (2 * s);
  return code;
}

/* What the contacts of one body and one of its rotations said so far. */
typedef struct sense {
  double sign;
  int contact;
} sense;

/* What a contact says of one rotation: an arm b, what it is about. */
typedef struct arm {
  int contact, velocity;
  double a, b, turns, bend; /* n x t; v^T H v */
  turning rate;
} arm;

/* What differences may be off. */
static double small_of(const arm *x, double tol)
{
  return 100 * tol * (1 + fabs(x->bend));
}

static void judge(const nsdae_system *s, const arm *x, double tol, sense *seen, char *text,
                  size_t size)
{
  char contact[NSDAE_CALLED_SIZE], velocity[NSDAE_CALLED_SIZE], other[NSDAE_CALLED_SIZE];
  double small = small_of(x, tol), sign = 0;
  /* s of (1), where a is long enough to tell; it should be -1 or 1 */
  double found = (x->rate.arm + x->rate.normal * x->a) / (x->turns * x->a);
  int tells = fabs(x->a) > 0.05 * (fabs(x->b) + fabs(x->bend)) && isfinite(found);
  /* neither gap nor directions change along the turn, and it is no disc's: it moves the body and
   * turns nothing */
  int moves_along = fabs(x->a) > small && fabs(x->bend) <= small && fabs(x->rate.arm) <= small &&
                    fabs(x->rate.normal) <= small;
  if (!isfinite(x->bend) || moves_along) return;
  nsdae_system_called(s, NSDAE_NAME_CONTACT, x->contact, contact);
  nsdae_system_called(s, NSDAE_NAME_VELOCITY, x->velocity, velocity);
  if (x->bend > fabs(x->b) + small) {
    snprintf(text, size,
             "gap_tangent: its arm %.4g of %s along %s, if this rotates the body: it should be at "
             "least %.4g, otherwise a rotation about the contact opens the gap",
             x->b + 0.0, contact, velocity, x->bend); /* no -0 */
  } else if (tells) {
    double normal = x->rate.normal;
    if (fabs(fabs(found) - 1) > 0.01)
      snprintf(
          text, size,
          "gap_tangent: its arm %.4g of %s along %s, if this rotates the body: a rotation about "
          "the contact changes it at the rate %.4g, and the arm of a point at %.4g or %.4g",
          x->b + 0.0, contact, velocity, x->rate.arm + 0.0, (x->turns - normal) * x->a + 0.0,
          (-x->turns - normal) * x->a + 0.0);
    sign = -found;
  } else if (x->bend > -fabs(x->b) * (1 - 1e-3) && fabs(x->b) > tol) {
    sign = x->turns * x->b;
  }
  if (*text || sign == 0) return;
  if (seen->sign * sign < 0)
    snprintf(text, size, "gap_tangent: the sign of its arm of %s along %s, which differs at %s",
             contact, velocity, nsdae_system_called(s, NSDAE_NAME_CONTACT, seen->contact, other));
  if (seen->sign == 0) *seen = (sense){sign, x->contact};
}

static int doubt_one(nsdae_moment_arms *arms, int i, int of, int j, double tol, sense *seen,
                     char *text, size_t size)
{
  const nsdae_contact_directions c = nsdae_tangent_contact(&arms->all, i);
  const sense before = *seen;
  arm x = {i, j, .a = c.normal[j], .b = c.tangent[j], .turns = turns(&c, of, tol)};
  int bends = 1;
  /* v = e_j - a n - b t, of the translations of velocity `of` */
  for (int l = 0; l < c.nv; l++)
    arms->v[l] =
        nsdae_tangent_translates(&c, of, l, tol) ? -x.a * c.normal[l] - x.b * c.tangent[l] : 0;
  arms->v[j] = 1;
  int code = nsdae_moment_arms_bend(arms, i, &x.bend);
  if (code) return code;
  code = nsdae_kinematics(c.system, arms->t, arms->q, arms->v, arms->rate);
  if (code) arms->differences->failed = "kinematics";
  double s = nsdae_differences_step(c.system->dims.nq, arms->t, arms->q, arms->rate, 1e-5);
  if (!code) code = add_side(arms, &c, i, of, j, s, tol, &x.rate);
  if (!code) code = add_side(arms, &c, i, of, j, -s, tol, &x.rate);
  if (!code) judge(c.system, &x, tol, seen, text, size);
  if (!code && *text) code = nsdae_moment_arms_bends(arms, i, x.bend, small_of(&x, tol), &bends);
  if (bends) return code;
  *text = '\0';
  *seen = before;
  return code;
}

/* Whether contact i has to do with velocity j, which moves alone, beside the body that `of` moves,
 * which slides there. */
static int concerns(const nsdae_contact_directions *c, int i, int of, int j, double tol)
{
  if (!(c->system->contact[i].mu > 0) || c->set[j] == NSDAE_TANGENT_COUPLED) return 0;
  /* not what has a length per second as its unit */
  const char *unit = nsdae_system_get_unit(c->system, NSDAE_NAME_VELOCITY, j);
  size_t length = strlen(unit);
  if (length >= 3 && strcmp(unit + length - 3, "m/s") == 0) return 0;
  if (c->normal[j] == 0 && c->other[j] == 0 && c->tangent[j] == 0) return 0;
  if (!nsdae_tangent_translates(c, of, of, tol) || nsdae_tangent_translates(c, of, j, tol))
    return 0;
  return turns(c, of, tol) != 0;
}

int nsdae_moment_arms_doubt(nsdae_moment_arms *arms, double tol, char *text, size_t size)
{
  const nsdae_system *s = arms->all.system;
  int n = arms->all.nv, code = 0;
  *text = '\0';
  for (int of = 0; of < n; of++)
    for (int j = 0; j < n && arms->all.set[of] == of; j++) {
      sense seen = {0};
      for (int i = 0; i < s->dims.k && code == 0 && !*text; i++) {
        const nsdae_contact_directions c = nsdae_tangent_contact(&arms->all, i);
        if (!concerns(&c, i, of, j, tol)) continue;
        code = doubt_one(arms, i, of, j, tol, &seen, text, size);
      }
    }
  return code;
}
