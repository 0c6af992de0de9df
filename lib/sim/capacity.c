/* Room in the lists of contacts and of rows of Phi_q and W_S^T: it grows between steps, by half as
 * much again as was called for, in every list at once. */
#include "errors.h"
#include "sim_impl.h"

static nsdae_room larger(const nsdae_room *a, const nsdae_room *b)
{
  return (nsdae_room){a->entries > b->entries ? a->entries : b->entries,
                      a->values > b->values ? a->values : b->values};
}

int nsdae_sim_make_room(nsdae_sim *sim, const nsdae_room *contacts, const nsdae_room *rows)
{
  const nsdae_room c = larger(&sim->lists.contacts, contacts), r = larger(&sim->lists.rows, rows);
  int status = nsdae_terms_grow(&sim->stepper.middle, &c, &r);
  for (int i = 0; i < (sim->aside ? 3 : 2) && status == NSDAE_OK; i++) {
    status = nsdae_result_grow(&sim->point[i].result, &c, &r);
    nsdae_point_show_arrays(&sim->point[i]);
  }
  if (status == NSDAE_OK) status = nsdae_problem_grow(&sim->stepper.problem, &c, &r);
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

int nsdae_sim_grow(nsdae_sim *sim)
{
  const nsdae_terms *const all[] = {&sim->stepper.middle, &sim->point[0].result.end,
                                    &sim->point[1].result.end, &sim->point[2].result.end};
  nsdae_room contacts = {0}, rows = {0};
  for (int i = 0; i < 4; i++) {
    contacts = larger(&contacts, &all[i]->by.list.taken);
    rows = larger(&rows, &all[i]->by.rows.taken);
    rows = larger(&rows, &all[i]->by.joint_rows.taken);
  }
  size_t most = (size_t)sim->options.contacts_max;
  if (contacts.entries > most)
    return nsdae_error_set(&sim->error, NSDAE_E_ARGUMENT, "nsdae_sim", "contacts_max",
                           "the contact list has %zu contacts at t = %.17g, more than contacts_max "
                           "= %d: make it larger, "
                           "or check the callback contacts",
                           contacts.entries, nsdae_terms_time(&sim->now->result.end),
                           sim->options.contacts_max);
  contacts = half_more(&sim->lists.contacts, &contacts);
  rows = half_more(&sim->lists.rows, &rows);
  if (contacts.entries > most) contacts.entries = most;
  int status = nsdae_sim_make_room(sim, &contacts, &rows);
  if (status == NSDAE_OK) sim->lists.growths++;
  return status;
}
