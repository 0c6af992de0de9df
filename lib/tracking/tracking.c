#include "tracking.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "errors.h"

/* Of the speed at the start of a step, what the reach assumes for the rest of it. */
static const double FASTER = 1.25;

/* Of the largest W_N and velocities: rounding of a gap's rate, and of contact_speed. */
static const double ROUNDING = 1e-9;

/* Of a time: within which a root is found (dip.c). */
static const double BRACKET = 100 * DBL_EPSILON;

/* Factor of the reach, and how often, to have at the start what was listed later. */
static const double WIDER = 4;
enum { WIDEST = 3 };

/* A new contact in the step at hand. */
enum { NEW = 2 };

void nsdae_tracking_layout(nsdae_tracking *t, nsdae_arena *arena)
{
  nsdae_arena_ints(arena, t->model->dims.k, (int **[]){&t->fresh, &t->seen, &t->closes, NULL});
  t->anew = NSDAE_ARENA_DOUBLES(arena, t->model->dims.nv + 2L);
}

/* ---- memory */

void nsdae_tracking_lay(nsdae_tracking *t, const nsdae_system *model, nsdae_memory_part *part)
{
  t->used = nsdae_memory_wholes(part, NSDAE_BY_SLOT(1));
  t->block = nsdae_memory_wholes(part, NSDAE_BY_SLOT(2));
  t->id = nsdae_memory_wholes(part, NSDAE_BY_SLOT(2));
  t->law = nsdae_memory_reals(part, NSDAE_BY_SLOT(3));
  t->lever = nsdae_memory_reals(part, NSDAE_OF_ALL((size_t)model->dims.nv));
  t->still = nsdae_memory_reals(part, NSDAE_OF_ALL(2));
}

void nsdae_tracking_store(const nsdae_tracking *t)
{
  for (int i = 0; i < t->model->dims.k; i++) {
    const nsdae_coefficients *c = &t->model->contact[i];
    uint64_t id = (uint64_t)t->table->id[i];
    const int used = t->table->used[i];
    t->used[i] = used;
    t->id[2 * i] = used ? (int)(int32_t)(uint32_t)(id >> 32) : 0;
    t->id[2 * i + 1] = used ? (int)(int32_t)(uint32_t)id : 0;
    for (int s = 0; s < 2; s++) t->block[2 * i + s] = used ? t->table->block[2 * i + s] : 0;
    t->law[3 * i] = used ? c->mu : 0;
    t->law[3 * i + 1] = used ? c->e_n : 0;
    t->law[3 * i + 2] = used ? c->e_t : 0;
  }
  t->still[1] = t->table->reach;
}

void nsdae_tracking_load(nsdae_tracking *t)
{
  for (int i = 0; i < t->model->dims.k; i++) {
    const double *law = t->law + 3 * (size_t)i;
    t->table->used[i] = t->used[i];
    t->table->id[i] =
        (long)(int64_t)((uint64_t)(uint32_t)t->id[2 * i] << 32 | (uint32_t)t->id[2 * i + 1]);
    for (int s = 0; s < 2; s++) t->table->block[2 * i + s] = t->block[2 * i + s];
    t->model->contact[i] = (nsdae_coefficients){law[0], law[1], law[2], 1};
    t->fresh[i] = 0;
  }
  t->table->reach = t->still[1];
  nsdae_tracked_sort(t->table, t->model->dims.k);
}

int nsdae_tracking_is_valid(const nsdae_tracking *t)
{
  int valid = 1;
  for (int i = 0; t->table && i < t->model->dims.k; i++) {
    valid &= t->used[i] == 0 || t->used[i] == 1;
    for (int s = 2 * i; s < 2 * i + 2; s++)
      valid &= t->block[s] >= -1 && t->block[s] < t->model->blocks.count;
  }
  return valid;
}

/* ---- speed */

/* Largest |W_N| at each velocity, and |w_N|, of a list. */
static void learn(nsdae_tracking *t, const nsdae_contact_list *list)
{
  const nsdae_blocks *blocks = &t->model->blocks;
  for (int i = 0; i < list->count; i++) {
    t->still[0] = fmax(t->still[0], fabs(list->w[i * (1 + list->nt)]));
    for (int side = 2 * i; side < 2 * i + 2; side++) {
      int b = list->block[side], n = b < 0 ? 0 : nsdae_blocks_size(blocks, b);
      const double *W = list->value + list->at[side];
      double *lever = t->lever + (n ? blocks->first[b] : 0);
      for (int j = 0; j < n; j++) lever[j] = fmax(lever[j], fabs(W[j]));
    }
  }
}

static double estimate(const nsdae_tracking *t, const double *v)
{
  const nsdae_blocks *blocks = &t->model->blocks;
  const double *width = t->model->size[NSDAE_NAME_CONTACT];
  double fastest = 0, second = 0;
  for (int b = 0; b < blocks->count; b++) {
    double sum = 0, least = fmax(1, width ? width[b] : 0);
    for (int j = blocks->first[b]; j < blocks->first[b + 1]; j++)
      sum += fmax(least, t->lever[j]) * fabs(v[j]);
    second = fmax(second, fmin(sum, fastest));
    fastest = fmax(sum, fastest);
  }
  return 2 * (fastest + second + t->still[0]);
}

static int speed_at(nsdae_tracking *t, const nsdae_terms *T, double *speed)
{
  const nsdae_system *s = t->model;
  double time = nsdae_terms_time(T);
  *speed = 0;
  if (!s->call.contact_speed) {
    *speed = estimate(t, T->v);
    return NSDAE_OK;
  }
  int code = s->call.contact_speed(time, T->q, T->v, speed, s->user);
  int status = nsdae_system_callback_status(code, "contact_speed", time, t->error);
  if (status < 0 || (*speed >= 0 && isfinite(*speed))) return status;
  status = isfinite(*speed) ? NSDAE_E_CALLBACK : NSDAE_E_NONFINITE;
  nsdae_error_set(t->error, status, "nsdae_sim", "contact_speed",
                  "contact_speed gave %g at t = %g: it must be at least 0, finite", *speed, time);
  return nsdae_error_at(t->error, status, -1, time);
}

/* The rate of entry i, and how large its terms are, with what is zero up to rounding in W. */
static double rate_of(const nsdae_contact_list *list, int i, const double *v, double *size)
{
  double largest = 0, sum = 0;
  for (int side = 2 * i; side < 2 * i + 2; side++) {
    int b = list->block[side], n = b < 0 ? 0 : nsdae_blocks_size(list->blocks, b);
    const double *W = list->value + list->at[side];
    for (int j = 0; j < n; j++) {
      largest = fmax(largest, fabs(W[j]));
      sum += fabs(v[list->blocks->first[b] + j]);
    }
  }
  *size = largest * sum + fabs(list->w[i * (1 + list->nt)]);
  return fabs(nsdae_contact_list_velocity(list, i, 0, v));
}

static int error_of(const nsdae_tracking *t, const nsdae_terms *T, long id)
{
  return nsdae_error_at(t->error, NSDAE_E_CALLBACK, id >= 0 && id <= INT32_MAX ? (int)id : -1,
                        nsdae_terms_time(T));
}

/* Whether no listed contact is faster than contact_speed says. */
static int check_speed(const nsdae_tracking *t, const nsdae_terms *T, double speed)
{
  const nsdae_contact_list *list = &T->by.list;
  char called[NSDAE_CALLED_SIZE];
  for (int i = 0; i < list->count; i++) {
    double size, rate = rate_of(list, i, T->v, &size);
    if (rate <= speed + ROUNDING * size) continue;
    nsdae_error_set(t->error, NSDAE_E_CALLBACK, "nsdae_sim", "contact_speed",
                    "contact_speed gave %g at t = %g, but the gap of %s has the rate %g: it must "
                    "be a bound of all contacts",
                    speed, nsdae_terms_time(T),
                    nsdae_system_called_id(t->model, list->id[i], called), rate);
    return error_of(t, T, list->id[i]);
  }
  return NSDAE_OK;
}

/* ---- slots */

/* Contact i of the list gets the first slot that is free; -1: none is. */
static int take_slot(nsdae_tracking *t, const nsdae_contact_list *list, int i)
{
  int slot = 0, k = t->model->dims.k;
  t->table->wanted++;
  while (slot < k && t->table->used[slot]) slot++;
  if (slot == k) return -1;
  t->table->used[slot] = 1;
  t->table->id[slot] = list->id[i];
  t->fresh[slot] = NEW;
  return slot;
}

/* The list at the terms' point within a reach; those up to it that have no slot get one, unless
 * added is NULL. */
static int ask(nsdae_tracking *t, nsdae_terms *T, double reach, double speed, int *added)
{
  const nsdae_contact_list *list = &T->by.list;
  int k = t->model->dims.k, full = 0, *place = T->by.place, status = nsdae_terms_contacts(T, reach);
  if (status == NSDAE_OK && t->model->call.contact_speed) status = check_speed(t, T, speed);
  if (status < 0) return status;
  if (!t->model->call.contact_speed) learn(t, list);
  memset(t->seen, 0, (size_t)k * sizeof *t->seen);
  nsdae_terms_forget_slots(T);
  for (int i = 0; i < k; i++) place[i] = -1;
  for (int i = 0, last = -1; i < list->count; i++) {
    int slot = nsdae_tracked_find(t->table, k, list->id[i], last + 1);
    if (slot < 0 && (!added || !(list->gap[i] <= reach))) continue;
    if (slot >= 0) status = nsdae_terms_same_blocks(T, i, slot);
    if (status < 0) return status;
    if (slot < 0) *added += (slot = take_slot(t, list, i)) >= 0;
    full |= slot < 0;
    if (slot < 0) continue;
    if (place[slot] >= 0) return nsdae_terms_id_twice(T, list->id[i]);
    place[last = slot] = i;
    memcpy(t->table->block + 2 * slot, list->block + 2 * i, 2 * sizeof *list->block);
    t->seen[slot] = list->gap[i] <= reach;
    t->model->contact[slot] = list->law[i];
  }
  if (added) nsdae_tracked_sort(t->table, k);
  return full ? NSDAE_ARRAYS_GROW : NSDAE_OK;
}

/* Slots in use. */
static void count_slots(nsdae_tracking *t)
{
  t->table->wanted = 0;
  for (int i = 0; i < t->model->dims.k; i++) t->table->wanted += t->table->used[i];
}

/* The largest overlap in the list. */
static double deepest(const nsdae_contact_list *list)
{
  double deep = 0;
  for (int i = 0; i < list->count; i++) deep = fmax(deep, -list->gap[i]);
  return deep;
}

int nsdae_tracking_begin(nsdae_tracking *t, nsdae_terms *T, double h)
{
  double speed;
  int k = t->model->dims.k, added = 0, status = speed_at(t, T, &speed);
  if (status < 0) return status;
  memset(t->table->used, 0, (size_t)k * sizeof *t->table->used);
  count_slots(t);
  t->table->reach = t->near + h * speed;
  status = ask(t, T, t->table->reach, speed, &added);
  double deep = deepest(&T->by.list);
  if (status == NSDAE_OK && deep > t->near) { /* its projection brings others nearer */
    t->table->reach += deep;
    status = ask(t, T, t->table->reach, speed, &added);
  }
  for (int i = 0; i < k; i++) t->fresh[i] = t->fresh[i] != 0;
  return status;
}

int nsdae_tracking_begin_anew(nsdae_tracking *t, nsdae_terms *T, double h)
{
  nsdae_tracking alone = *t;
  size_t n = (size_t)t->model->dims.nv;
  memset(t->anew, 0, (n + 2) * sizeof *t->anew);
  alone.lever = t->anew;
  alone.still = t->anew + n;
  int status = nsdae_tracking_begin(&alone, T, h);
  memset(t->fresh, 0, (size_t)t->model->dims.k * sizeof *t->fresh);
  return status;
}

int nsdae_tracking_add(nsdae_tracking *t, nsdae_terms *T)
{
  double speed;
  int added = 0, status = speed_at(t, T, &speed);
  count_slots(t);
  if (status == NSDAE_OK) status = ask(t, T, t->near, speed, &added);
  for (int i = 0; i < t->model->dims.k; i++) t->fresh[i] = t->fresh[i] != 0;
  return status;
}

int nsdae_tracking_trim(nsdae_tracking *t, nsdae_terms *T, double h, const int *keep)
{
  double speed;
  int status = speed_at(t, T, &speed);
  if (status == NSDAE_OK) status = ask(t, T, t->near + h * speed, speed, NULL);
  for (int i = 0; i < t->model->dims.k && status == NSDAE_OK; i++)
    t->table->used[i] &= keep[i] || t->seen[i];
  nsdae_tracked_sort(t->table, t->model->dims.k);
  return status;
}

int nsdae_tracking_widen(nsdae_tracking *t, nsdae_terms *T, double h)
{
  double speed;
  int status = speed_at(t, T, &speed);
  if (status < 0 || !(t->near + WIDER * h * speed > t->table->reach)) return status;
  t->table->reach = t->near + WIDER * h * speed;
  nsdae_terms_forget_slots(T);
  return NSDAE_OK;
}

/* ---- a step */

static int not_in_time(const nsdae_tracking *t, const nsdae_terms *T, int slot, double gap)
{
  char called[NSDAE_CALLED_SIZE];
  nsdae_error_set(
      t->error, NSDAE_E_CALLBACK, "nsdae_sim", "contacts",
      "contacts did not list %s in time: its gap is %g at t = %g, before which it was not "
      "listed within %g; list every contact within reach, or set contact_speed",
      nsdae_system_called_id(t->model, t->table->id[slot], called), gap, nsdae_terms_time(T),
      t->table->reach);
  return error_of(t, T, t->table->id[slot]);
}

/* The first new contact that was not listed where the list was asked last; -1: none. */
static int unlisted(const nsdae_tracking *t)
{
  for (int i = 0; i < t->model->dims.k; i++)
    if (t->fresh[i] == NEW && !t->seen[i]) return i;
  return -1;
}

/* New contacts at the start of the step: within a reach that has them there. One that is then
 * nearer than `near` below zero was not listed in time. One that is not there at all may be that of
 * another feature later in the step: see nsdae_tracking_close. */
static int find_at_start(nsdae_tracking *t, double from, double reach, double speed)
{
  nsdae_terms *T;
  int status = t->look(from, &T, t->user);
  for (int n = 0; n <= WIDEST && status == NSDAE_OK; n++) {
    if (n > 0) reach *= WIDER;
    status = ask(t, T, reach, speed, NULL);
    if (status == NSDAE_OK && unlisted(t) < 0) break;
  }
  if (status < 0) return status;
  t->table->reach = fmax(t->table->reach, reach);
  const nsdae_contact_list *list = &T->by.list;
  for (int i = 0, last = -1; i < list->count; i++) {
    int slot = nsdae_tracked_find(t->table, t->model->dims.k, list->id[i], last + 1);
    if (slot < 0) continue;
    last = slot;
    if (t->fresh[slot] == NEW && list->gap[i] < -t->near)
      return not_in_time(t, T, slot, list->gap[i]);
  }
  return NSDAE_OK;
}

int nsdae_tracking_cover(nsdae_tracking *t, double from, double to)
{
  const double h = to - from, at[3] = {from, from + h / 2, to};
  double fastest = 0, reach = -1;
  int added = 0, status = NSDAE_OK;
  nsdae_terms *T;
  count_slots(t);
  /* until the reach was enough for the fastest of the three points */
  while (status == NSDAE_OK && reach < t->near + h * fastest) {
    double least = INFINITY;
    for (int i = 0; i < 3 && status == NSDAE_OK; i++) {
      double speed = 0;
      status = t->look(at[i], &T, t->user);
      if (status == NSDAE_OK) status = speed_at(t, T, &speed);
      fastest = fmax(fastest, speed);
      reach = t->near + h * FASTER * fastest;
      least = fmin(least, reach);
      if (status == NSDAE_OK) status = ask(t, T, reach, speed, &added);
      if (!t->model->call.contact_speed) fastest = fmax(fastest, estimate(t, T->v));
    }
    reach = least;
  }
  if (status == NSDAE_OK) t->table->reach = fmax(reach, t->near + t->longest * fastest);
  if (status == NSDAE_OK && added) status = find_at_start(t, from, reach, fastest);
  for (int i = 0; i < t->model->dims.k; i++) t->fresh[i] = t->fresh[i] != 0;
  return status < 0 ? status : added;
}

int nsdae_tracking_close(nsdae_tracking *t, double from, double to)
{
  const double at[3] = {to, from, to}, within = BRACKET * (fabs(to) + (to - from));
  int k = t->model->dims.k, any = 0, late = -1, status = NSDAE_OK;
  nsdae_terms *T;
  for (int i = 0; i < k; i++) any |= t->closes[i];
  for (int n = 0; n < 3 && any && status == NSDAE_OK; n++) {
    status = t->look(at[n], &T, t->user);
    if (status == NSDAE_OK)
      status = nsdae_terms_need(T, NSDAE_TERM_GAP | NSDAE_TERM_NORMAL | NSDAE_TERM_BIAS);
    if (status < 0) return status;
    if (n == 2) return not_in_time(t, T, late, T->gap[late]);
    any = 0;
    for (int i = 0; i < k; i++) {
      double way = within * fabs(nsdae_terms_normal_rate(T, i, T->v));
      t->closes[i] &= n == 0 ? T->gap[i] < -(t->near + way) : !(T->gap[i] < NSDAE_FAR);
      if (t->closes[i]) any = 1, late = i;
    }
  }
  return status;
}

int nsdae_tracking_show(const nsdae_tracking *t, nsdae_terms *from, nsdae_terms *T,
                        const int *needed)
{
  double *reach = &t->table->reach, own = *reach;
  nsdae_terms_forget_slots(from); /* slots may have others now */
  int missing = 1, status = nsdae_terms_need(from, NSDAE_TERM_GAP);
  if (status < 0) return status;
  for (int n = 0; missing && n <= WIDEST && status == NSDAE_OK; n++) {
    if (n > 0) *reach *= WIDER;
    nsdae_terms_forget_slots(T);
    status = nsdae_terms_need(T, NSDAE_TERM_GAP);
    missing = 0;
    for (int i = 0; i < t->model->dims.k && status == NSDAE_OK; i++)
      missing |= needed[i] && t->table->used[i] && !(T->gap[i] < NSDAE_FAR);
  }
  for (int i = 0; i < t->model->dims.k; i++) {
    t->seen[i] = T->gap[i] < NSDAE_FAR;
    if (needed[i] && !t->seen[i]) T->gap[i] = *reach;
  }
  *reach = own;
  return status;
}
