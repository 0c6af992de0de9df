/* Room in the lists of contacts and of rows of Phi_q and W_S^T: it grows between steps, by half as
 * much again as was called for, in every list at once. */
#include <string.h>

#include "arena.h"
#include "errors.h"
#include "listed.h"
#include "sim_impl.h"

int nsdae_sim_make_room(nsdae_sim *sim, const nsdae_room *contacts, const nsdae_room *rows)
{
  const nsdae_room c = nsdae_room_larger(&sim->lists.contacts, contacts),
                   r = nsdae_room_larger(&sim->lists.rows, rows);
  int status = nsdae_problem_grow(&sim->stepper.problem, &c, &r), points = sim->aside ? 3 : 2;
  if (status == NSDAE_OK) status = nsdae_projector_grow(&sim->projection, &c, &r);
  if (status == NSDAE_OK && nsdae_sim_projection(&sim->options) == NSDAE_PROJECTION_SLOP)
    status = nsdae_slop_grow(&sim->slop, &sim->model, &c, &r);
  for (int i = 0; i < points && status == NSDAE_OK; i++)
    status = nsdae_result_grow(&sim->point[i].result, &c);
  /* the lists last: what is made from a list has room for all of it */
  for (int i = 0; i < points && status == NSDAE_OK; i++)
    status = nsdae_terms_grow(&sim->point[i].result.end, &c, &r);
  if (status == NSDAE_OK) status = nsdae_terms_grow(&sim->stepper.middle, &c, &r);
  for (int i = 0; i < points; i++) nsdae_point_show_arrays(&sim->point[i]);
  if (status < 0)
    return nsdae_error_set(&sim->error, NSDAE_E_MEMORY, "nsdae_sim", "contacts",
                           "out of memory for lists of %zu contacts and of %zu blocks of rows of "
                           "Phi_q",
                           c.entries, r.entries);
  sim->lists.contacts = c;
  sim->lists.rows = r;
  return NSDAE_OK;
}

static nsdae_room half_more(const nsdae_room *room, const nsdae_room *taken)
{
  if (nsdae_room_enough(room, taken)) return *room;
  return (nsdae_room){taken->entries + taken->entries / 2, taken->values + taken->values / 2};
}

static int slots_to_have(const nsdae_sim *sim)
{
  int k = sim->model.dims.k + sim->model.dims.k / 2, wanted = sim->tracked.wanted;
  return wanted > k ? wanted : k;
}

int nsdae_sim_enlarge(nsdae_sim *sim, double t, const nsdae_room *taken, nsdae_room *contacts,
                      nsdae_room *rows)
{
  size_t most = (size_t)sim->options.contacts_max;
  if (taken[0].entries > most)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim", "contacts_max",
                           "the contact list has %zu contacts at t = %g, more than contacts_max "
                           "= %d: make it larger, or check the callback contacts",
                           taken[0].entries, t, sim->options.contacts_max);
  *contacts = half_more(contacts, &taken[0]);
  *rows = half_more(rows, &taken[1]);
  if (contacts->entries > most) contacts->entries = most;
  return NSDAE_OK;
}

/* What grows is asked for by lists without room, by slots, or by islands of listed contacts. */
int nsdae_sim_grow(nsdae_sim *sim)
{
  const nsdae_room *wanted = sim->stepper.differences.by_id.wanted;
  nsdae_room contacts = sim->lists.contacts, rows = sim->lists.rows;
  double t = nsdae_terms_time(&sim->now->result.end);
  int status = nsdae_sim_enlarge(sim, t, wanted, &contacts, &rows);
  if (status < 0) return status;
  if (nsdae_room_enough(&sim->lists.contacts, &wanted[0]) &&
      nsdae_room_enough(&sim->lists.rows, &wanted[1]) &&
      (sim->model.tracked || !sim->model.call.contacts)) {
    if (sim->model.tracked && sim->tracked.wanted > sim->model.dims.k)
      return nsdae_sim_make_slots(sim, slots_to_have(sim));
    return nsdae_error_set(&sim->error, NSDAE_E_MEMORY, "nsdae_sim", "method",
                           "method = %s has no room in a list after t = %g, but no list asks for "
                           "more: use method = implicit",
                           sim->method->name, t);
  }
  status = nsdae_sim_make_room(sim, &contacts, &rows);
  if (status == NSDAE_OK) sim->lists.growths++;
  return status;
}

/* ---- slots of tracked contacts: the model's k */

/* Of all arrays by contact, which the arena has, the lengths. */
static void change_slots(void *object, int back)
{
  nsdae_sim *sim = object;
  sim->model.dims.k = back ? sim->lists.slots_before : sim->lists.slots;
  nsdae_sim_measure(sim);
}

void nsdae_sim_carry_memory(const nsdae_sim *sim, const nsdae_memory *from, int from_slots,
                            nsdae_memory *to, int slots)
{
  nsdae_memory_part old = {.real = from->real, .whole = from->whole, .slots = (size_t)from_slots};
  nsdae_memory_part part = {
      .real = to->real, .whole = to->whole, .slots = (size_t)slots, .from = &old};
  memset(to->real, 0, to->reals * sizeof *to->real);
  memset(to->whole, 0, to->wholes * sizeof *to->whole);
  sim->method->lay(&sim->stepper, &part);
}

/* What is not slot by slot in one array; what points to the method's own. */
static void carry(nsdae_sim *sim, nsdae_result *to, const nsdae_result *was)
{
  const nsdae_dims *d = &sim->model.dims;
  int before = sim->lists.slots_before;
  nsdae_sim_carry_memory(sim, &was->memory, before, &to->memory, d->k);
  if (to->memory.stamp > 0) to->memory.stamp = -1;
  nsdae_impulses_carry(&to->impulses, d, before, &was->impulses);
  to->problem = NULL;
  nsdae_terms_forget_slots(&to->end);
}

/* The method that is there goes on: coefficients may have moved with the model's contacts. */
static void keep_method(nsdae_sim *sim)
{
  if (!sim->own) return;
  nsdae_stepper_prepare(&sim->stepper);
  sim->method->prepare(sim->own);
}

static int no_memory_for_slots(nsdae_sim *sim, int k)
{
  keep_method(sim);
  return nsdae_error_set(&sim->error, NSDAE_E_MEMORY, "nsdae_sim", "contacts",
                         "out of memory for %d contacts of the list near the motion", k);
}

/* The contact problem of all that are tracked is one, and has its limit. */
int nsdae_sim_most_slots(const nsdae_sim *sim)
{
  int edges = nsdae_law_edges_to_start(sim->options.polygon);
  return nsdae_contacts_rows_limit() / nsdae_law_rows(sim->model.dims.nt, 1, edges);
}

static int check_slots(nsdae_sim *sim, int k)
{
  int most = nsdae_sim_most_slots(sim);
  if (k <= most) return NSDAE_OK;
  return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim", "method",
                         "method = %s has %d contacts near the motion at t = %g, and at most "
                         "%d: use method = implicit",
                         sim->method->name, k, nsdae_terms_time(&sim->now->result.end), most);
}

int nsdae_sim_make_slots(nsdae_sim *sim, int k)
{
  const nsdae_array table[] = {NSDAE_ARRAY(sim->model.contact, 1), NSDAE_ARRAY(sim->tracked.id, 1),
                               NSDAE_ARRAY(sim->tracked.used, 1),
                               NSDAE_ARRAY(sim->tracked.block, 2),
                               NSDAE_ARRAY(sim->tracked.order, 1)};
  int before = sim->model.dims.k, status = check_slots(sim, k);
  if (status < 0) return status;
  if (nsdae_arrays_grow(table, 5, (size_t)k + 1) < 0) return no_memory_for_slots(sim, k);
  size_t more = (size_t)(k - before);
  memset(sim->tracked.used + before, 0, more * sizeof *sim->tracked.used);
  for (int i = before; i < k; i++) sim->tracked.order[i] = i;
  memset(sim->model.contact + before, 0, more * sizeof *sim->model.contact);
  sim->lists.slots_before = before;
  sim->lists.slots = k;
  if (!sim->arena.base) { /* at first */
    sim->model.dims.k = k;
    return NSDAE_OK;
  }
  nsdae_arena old;
  /* ---- the arrays, then the method */
  const nsdae_result was[] = {sim->point[0].result, sim->point[1].result, sim->point[2].result};
  void *own = sim->own;
  if (nsdae_arena_resize(&sim->arena, nsdae_sim_layout, change_slots, sim, &old) < 0)
    return no_memory_for_slots(sim, k);
  for (int i = 0; i < (sim->aside ? 3 : 2); i++) carry(sim, &sim->point[i].result, &was[i]);
  nsdae_terms_forget(&sim->stepper.middle);
  sim->own = NULL;
  status = nsdae_sim_make_method(sim);
  if (status < 0) {
    sim->method->destroy(sim->own);
    sim->own = own;
    nsdae_arena_restore(&sim->arena, nsdae_sim_layout, change_slots, sim, &old);
    keep_method(sim);
  } else {
    sim->method->destroy(own);
  }
  nsdae_arena_release(&old);
  return status < 0 ? status : nsdae_sim_make_room(sim, &sim->lists.contacts, &sim->lists.rows);
}

int nsdae_sim_track(nsdae_sim *sim, nsdae_terms *at, double h)
{
  if (!sim->model.tracked) return NSDAE_OK;
  memset(sim->tracked.used, 0, (size_t)sim->model.dims.k * sizeof *sim->tracked.used);
  nsdae_terms_forget_slots(at);
  return sim->method->track(sim->own, at, h);
}
