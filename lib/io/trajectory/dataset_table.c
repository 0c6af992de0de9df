#include "dataset_table.h"

#include <stddef.h>

#include "system_impl.h"

enum { ROWS = 1024, CONTACTS = 16 * ROWS };

#define TABLE(column, counts, chunk)                                    \
  {                                                                     \
    column, (int)(sizeof(column) / sizeof *(column)), (counts), (chunk) \
  }

#define FIELD(field)     offsetof(nsdae_record_row, record.field), 0, NSDAE_VALUE_REAL
#define INT_FIELD(field) offsetof(nsdae_record_row, record.field), 0, NSDAE_VALUE_INT
#define ROW(field)       offsetof(nsdae_record_row, record.field), 1, NSDAE_VALUE_REAL
#define INT_ROW(field)   offsetof(nsdae_record_row, record.field), 1, NSDAE_VALUE_INT

#define WHICH ", from 0; -1: the figure is 0"

static const nsdae_column record_columns[] = {
    {"/time", FIELD(time), NSDAE_WIDTH_ONE, "s", "simulated time"},
    {"/q", ROW(q), NSDAE_WIDTH_Q, "of the model", "coordinates"},
    {"/v", ROW(v), NSDAE_WIDTH_V, "of the model", "velocities"},
    {"/multiplier", ROW(multiplier), NSDAE_WIDTH_M, "of the model: force of each constraint",
     "mean bilateral force over the step that ends here"},
    {"/contact/gap", ROW(gap), NSDAE_WIDTH_K, "m",
     "normal distance, negative where bodies overlap"},
    {"/contact/normal_impulse", ROW(normal_impulse), NSDAE_WIDTH_K, "N s",
     "normal impulse of the step that ends here"},
    {"/contact/tangential_impulse", ROW(tangential_impulse), NSDAE_WIDTH_KT, "N s",
     "tangential impulse of the step that ends here"},
    {"/contact/mode", INT_ROW(mode), NSDAE_WIDTH_K, "1", "0 open, 1 slip, 2 stick"},
    {"/contacts/first", offsetof(nsdae_record_row, first), 0, NSDAE_VALUE_LONG, NSDAE_WIDTH_LISTED,
     "1", "row of the lists below at which the closed contacts of this record begin"},
    {"/contacts/count", INT_FIELD(contacts.count), NSDAE_WIDTH_LISTED, "1",
     "how many they are: contacts that were closed in the step that ends here"},
    {"/slide/impulse", ROW(frictional_joint_impulse), NSDAE_WIDTH_F, "N s",
     "friction impulse on each bilateral constraint with friction, of the step that ends here"},
    {"/slide/mode", INT_ROW(frictional_joint_mode), NSDAE_WIDTH_F, "1",
     "0 frictionless, 1 slip, 2 stick"},
    {"/energy/kinetic", FIELD(kinetic), NSDAE_WIDTH_ONE, "J", "v^T M v / 2"},
    {"/energy/potential", FIELD(potential), NSDAE_WIDTH_POTENTIAL, "J",
     "potential energy of the model; zero where it gives none"},
    {"/energy/dissipated", FIELD(dissipated), NSDAE_WIDTH_ONE, "J",
     "work taken by contact and friction impulses so far"},
    {"/energy/work", FIELD(certificate.work), NSDAE_WIDTH_ONE, "J",
     "work so far of forces outside the potential, moving constraints and contacts"},
    {"/energy/unexplained", FIELD(certificate.unexplained), NSDAE_WIDTH_ONE, "J",
     "change of energy + dissipated - work so far: < 0 is a loss of the method, > 0 a gain"},
    {"/certificate/lcp_residual", FIELD(lcp_residual), NSDAE_WIDTH_ONE, "1",
     "scaled natural residual of the step's complementarity problem"},
    {"/certificate/constraint_drift", FIELD(constraint_drift), NSDAE_WIDTH_ONE, "of the model",
     "max |Phi|"},
    {"/certificate/penetration", FIELD(penetration), NSDAE_WIDTH_ONE, "m",
     "largest overlap over the contacts"},
    {"/certificate/penetration_contact", INT_FIELD(certificate.penetration_contact),
     NSDAE_WIDTH_CONTACTS, "1", "contact of the largest overlap" WHICH},
    {"/certificate/pull", FIELD(certificate.pull), NSDAE_WIDTH_CONTACTS, "N s",
     "largest impulse by which a contact pulls"},
    {"/certificate/pull_contact", INT_FIELD(certificate.pull_contact), NSDAE_WIDTH_CONTACTS, "1",
     "that contact" WHICH},
    {"/certificate/cone_excess", FIELD(certificate.cone_excess), NSDAE_WIDTH_CONTACTS, "N s",
     "largest friction impulse beyond mu times the normal impulse"},
    {"/certificate/cone_contact", INT_FIELD(certificate.cone_contact), NSDAE_WIDTH_CONTACTS, "1",
     "contact of that excess" WHICH},
    {"/certificate/complementarity", FIELD(certificate.complementarity), NSDAE_WIDTH_CONTACTS, "J",
     "largest product of a normal impulse and the velocity that it should make zero"},
    {"/certificate/complementarity_contact", INT_FIELD(certificate.complementarity_contact),
     NSDAE_WIDTH_CONTACTS, "1", "contact of that product" WHICH},
    {"/certificate/drift_constraint", INT_FIELD(certificate.drift_constraint),
     NSDAE_WIDTH_CONSTRAINTS, "1", "constraint of max |Phi|" WHICH},
    {"/certificate/constraint_rate", FIELD(certificate.constraint_rate), NSDAE_WIDTH_CONSTRAINTS,
     "of the model", "max |dPhi/dt|"},
    {"/certificate/rate_constraint", INT_FIELD(certificate.rate_constraint),
     NSDAE_WIDTH_CONSTRAINTS, "1", "constraint of max |dPhi/dt|" WHICH},
};

const nsdae_table nsdae_record_table = TABLE(record_columns, 1, ROWS);

#undef FIELD
#undef INT_FIELD
#define FIELD(field)     offsetof(nsdae_impact_row, impact.field), 0, NSDAE_VALUE_REAL
#define INT_FIELD(field) offsetof(nsdae_impact_row, impact.field), 0, NSDAE_VALUE_INT

static const nsdae_column impact_columns[] = {
    {"/impact/time", FIELD(time), NSDAE_WIDTH_ONE, "s",
     "time of the impact; with a time-stepping method the end of its step"},
    {"/impact/contact", INT_FIELD(contact), NSDAE_WIDTH_NUMBERED, "1", "contact, from 0"},
    {"/impact/id", offsetof(nsdae_impact_row, id), 0, NSDAE_VALUE_LONG, NSDAE_WIDTH_LISTED, "1",
     "id of the contact"},
    {"/impact/block", offsetof(nsdae_impact_row, block), 0, NSDAE_VALUE_INT, NSDAE_WIDTH_PAIR, "1",
     "blocks of the contact; -1: the ground"},
    {"/impact/normal_impulse", FIELD(normal_impulse), NSDAE_WIDTH_ONE, "N s", "normal impulse"},
    {"/impact/tangential_impulse", FIELD(tangential_impulse), NSDAE_WIDTH_T, "N s",
     "tangential impulse"},
    {"/impact/velocity_before", FIELD(velocity_before), NSDAE_WIDTH_ONE, "m/s",
     "normal velocity before"},
    {"/impact/velocity_after", FIELD(velocity_after), NSDAE_WIDTH_ONE, "m/s",
     "normal velocity after"},
    {"/impact/peak_force", FIELD(peak_force), NSDAE_WIDTH_ONE, "N",
     "largest normal force of a continuous contact; 0 for a rigid one"},
    {"/impact/accumulation", INT_FIELD(accumulation), NSDAE_WIDTH_ONE, "1",
     "1 where the entry stands for infinitely many impacts that end at its time in rest"},
};

const nsdae_table nsdae_impact_table = TABLE(impact_columns, 1, ROWS);

#undef FIELD
#undef INT_FIELD
#define FIELD(field)     offsetof(nsdae_change, field), 0, NSDAE_VALUE_REAL
#define INT_FIELD(field) offsetof(nsdae_change, field), 0, NSDAE_VALUE_INT

static const nsdae_column change_columns[] = {
    {"/change/time", FIELD(time), NSDAE_WIDTH_ONE, "s", "instant of a change of mode"},
    {"/change/contact", INT_FIELD(contact), NSDAE_WIDTH_ONE, "1",
     "contact, from 0; -1: a frictional joint"},
    {"/change/slide", INT_FIELD(frictional_joint), NSDAE_WIDTH_ONE, "1",
     "frictional joint, from 0; -1: a contact"},
    {"/change/mode_before", INT_FIELD(mode_before), NSDAE_WIDTH_ONE, "1",
     "0 open, 1 slip, 2 stick"},
    {"/change/mode_after", INT_FIELD(mode_after), NSDAE_WIDTH_ONE, "1", "0 open, 1 slip, 2 stick"},
};

const nsdae_table nsdae_change_table = TABLE(change_columns, 1, ROWS);

#define LIST(field)     offsetof(nsdae_contact_set, field), 1, NSDAE_VALUE_REAL
#define INT_LIST(field) offsetof(nsdae_contact_set, field), 1, NSDAE_VALUE_INT

static const nsdae_column contact_columns[] = {
    {"/contacts/id", offsetof(nsdae_contact_set, id), 1, NSDAE_VALUE_LONG, NSDAE_WIDTH_LISTED, "1",
     "which contact, the same at all times"},
    {"/contacts/block", INT_LIST(block), NSDAE_WIDTH_PAIR, "1",
     "the blocks that touch; -1: the ground"},
    {"/contacts/gap", LIST(gap), NSDAE_WIDTH_LISTED, "m",
     "normal distance where the method looked last, negative where bodies overlap"},
    {"/contacts/normal_impulse", LIST(normal_impulse), NSDAE_WIDTH_LISTED, "N s",
     "normal impulse of the step"},
    {"/contacts/tangential_impulse", LIST(tangential_impulse), NSDAE_WIDTH_LISTED_T, "N s",
     "tangential impulse of the step"},
    {"/contacts/mode", INT_LIST(mode), NSDAE_WIDTH_LISTED, "1", "0 open, 1 slip, 2 stick"},
};

const nsdae_table nsdae_contact_table = TABLE(contact_columns, 0, CONTACTS);

void nsdae_sizes_of(nsdae_sizes *sizes, const nsdae_sim *sim)
{
  *sizes = (nsdae_sizes){.potential = nsdae_sim_has_potential(sim),
                         .listed = nsdae_sim_get_system(sim)->by_list};
  nsdae_sim_get_dims(sim, &sizes->dims);
}

int nsdae_width_shape(nsdae_width width, const nsdae_sizes *sizes, int shape[2])
{
  const nsdae_dims *dims = &sizes->dims;
  const int one[] = {[NSDAE_WIDTH_ONE] = 1,
                     [NSDAE_WIDTH_POTENTIAL] = sizes->potential,
                     [NSDAE_WIDTH_NUMBERED] = !sizes->listed,
                     [NSDAE_WIDTH_LISTED] = sizes->listed,
                     [NSDAE_WIDTH_CONTACTS] = sizes->listed || dims->k > 0,
                     [NSDAE_WIDTH_CONSTRAINTS] = dims->m > 0,
                     [NSDAE_WIDTH_PAIR] = 2 * sizes->listed,
                     [NSDAE_WIDTH_LISTED_T] = sizes->listed * dims->nt,
                     [NSDAE_WIDTH_Q] = dims->nq,
                     [NSDAE_WIDTH_V] = dims->nv,
                     [NSDAE_WIDTH_M] = dims->m,
                     [NSDAE_WIDTH_K] = dims->k,
                     [NSDAE_WIDTH_KT] = dims->k,
                     [NSDAE_WIDTH_T] = dims->nt,
                     [NSDAE_WIDTH_F] = dims->f};
  shape[0] = one[width];
  shape[1] = 1;
  if (width < NSDAE_WIDTH_PAIR) return 0;
  if (width != NSDAE_WIDTH_KT) return 1;
  shape[1] = dims->nt;
  return 2;
}
