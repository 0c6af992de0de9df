#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "system_impl.h"
#include "trajectory_impl.h"

enum { ROWS = 1024, CONTACTS = 16 * ROWS };

#define FIELD(field)      offsetof(nsdae_row, field), 0, NSDAE_VALUE_REAL
#define INT_FIELD(field)  offsetof(nsdae_row, field), 0, NSDAE_VALUE_INT
#define LONG_FIELD(field) offsetof(nsdae_row, field), 0, NSDAE_VALUE_LONG
#define ROW(field)        offsetof(nsdae_row, field), 1, NSDAE_VALUE_REAL
#define INT_ROW(field)    offsetof(nsdae_row, field), 1, NSDAE_VALUE_INT

#define WHICH ", from 0; -1: the figure is 0"

static const nsdae_column record_columns[] = {
    {"/time", FIELD(record.time), NSDAE_WIDTH_ONE, "s", "simulated time"},
    {"/q", ROW(record.q), NSDAE_WIDTH_Q, "of the model", "coordinates"},
    {"/v", ROW(record.v), NSDAE_WIDTH_V, "of the model", "velocities"},
    {"/multiplier", ROW(record.multiplier), NSDAE_WIDTH_M, "of the model: force of each constraint",
     "mean bilateral force over the step that ends here"},
    {"/contacts/first", LONG_FIELD(first), NSDAE_WIDTH_LIST, "1",
     "row of the lists below at which the contacts of this record begin"},
    {"/contacts/count", INT_FIELD(record.contacts.count), NSDAE_WIDTH_LIST, "1",
     "number of these contacts, which were closed in the step that ends here"},
    {"/frictional_joint/impulse", ROW(record.frictional_joint_impulse), NSDAE_WIDTH_F, "N s|N m s",
     "friction impulse of each frictional joint, of the step that ends here"},
    {"/frictional_joint/mode", INT_ROW(record.frictional_joint_mode), NSDAE_WIDTH_F, "1",
     "0 frictionless, 1 slip, 2 stick"},
    {"/energy/kinetic", FIELD(record.kinetic), NSDAE_WIDTH_ONE, "J", "v^T M v / 2"},
    {"/energy/potential", FIELD(record.potential), NSDAE_WIDTH_POTENTIAL, "J",
     "potential energy of the model; zero where it gives none"},
    {"/energy/dissipated", FIELD(record.dissipated), NSDAE_WIDTH_ONE, "J",
     "work taken by contact and friction impulses so far"},
    {"/energy/projection", FIELD(record.projection_energy), NSDAE_WIDTH_ONE, "J",
     "potential energy that projection = slop added so far; a part of dissipated, < 0 there"},
    {"/energy/work", FIELD(record.certificate.work), NSDAE_WIDTH_ONE, "J",
     "work so far of forces outside the potential, moving constraints and contacts"},
    {"/energy/unexplained", FIELD(record.certificate.unexplained), NSDAE_WIDTH_ONE, "J",
     "change of energy + dissipated - work so far: < 0 is a loss of the method, > 0 a gain"},
    {"/certificate/lcp_residual", FIELD(record.lcp_residual), NSDAE_WIDTH_ONE, "1",
     "scaled natural residual of the step's complementarity problem"},
    {"/certificate/contact_tol", FIELD(record.contact_tol), NSDAE_WIDTH_ONE, "1",
     "largest tolerance of the step's contact problems; 0: it had none"},
    {"/certificate/constraint_drift", FIELD(record.constraint_drift), NSDAE_WIDTH_ONE,
     "of the model", "max |Phi|"},
    {"/certificate/penetration", FIELD(record.penetration), NSDAE_WIDTH_ONE, "m|rad",
     "largest overlap over the contacts"},
    {"/certificate/penetration_contact", INT_FIELD(record.certificate.penetration_contact),
     NSDAE_WIDTH_CONTACTS, "1", "contact of the largest overlap" WHICH},
    {"/certificate/pull", FIELD(record.certificate.pull), NSDAE_WIDTH_CONTACTS, "N s|N m s",
     "largest impulse by which a contact pulls"},
    {"/certificate/pull_contact", INT_FIELD(record.certificate.pull_contact), NSDAE_WIDTH_CONTACTS,
     "1", "that contact" WHICH},
    {"/certificate/cone_excess", FIELD(record.certificate.cone_excess), NSDAE_WIDTH_CONTACTS, "N s",
     "largest friction impulse beyond mu times the normal impulse"},
    {"/certificate/cone_contact", INT_FIELD(record.certificate.cone_contact), NSDAE_WIDTH_CONTACTS,
     "1", "contact of that excess" WHICH},
    {"/certificate/complementarity", FIELD(record.certificate.complementarity),
     NSDAE_WIDTH_CONTACTS, "J",
     "largest product of a normal impulse and the velocity that it should make zero"},
    {"/certificate/complementarity_contact", INT_FIELD(record.certificate.complementarity_contact),
     NSDAE_WIDTH_CONTACTS, "1", "contact of that product" WHICH},
    {"/certificate/drift_constraint", INT_FIELD(record.certificate.drift_constraint),
     NSDAE_WIDTH_CONSTRAINTS, "1", "constraint of max |Phi|" WHICH},
    {"/certificate/constraint_rate", FIELD(record.certificate.constraint_rate),
     NSDAE_WIDTH_CONSTRAINTS, "of the model", "max |dPhi/dt|"},
    {"/certificate/rate_constraint", INT_FIELD(record.certificate.rate_constraint),
     NSDAE_WIDTH_CONSTRAINTS, "1", "constraint of max |dPhi/dt|" WHICH},
};

static const nsdae_column impact_columns[] = {
    {"/impact/time", FIELD(impact.time), NSDAE_WIDTH_ONE, "s",
     "time of the impact; with a time-stepping method the end of its step"},
    {"/impact/id", LONG_FIELD(impact.id), NSDAE_WIDTH_ONE, "1", "id of the contact"},
    {"/impact/block", INT_FIELD(impact.block), NSDAE_WIDTH_PAIR, "1",
     "blocks of the contact; -1: the ground"},
    {"/impact/normal_impulse", FIELD(impact.normal_impulse), NSDAE_WIDTH_ONE, "N s|N m s",
     "normal impulse"},
    {"/impact/tangential_impulse", FIELD(impact.tangential_impulse), NSDAE_WIDTH_T, "N s",
     "tangential impulse"},
    {"/impact/velocity_before", FIELD(impact.velocity_before), NSDAE_WIDTH_ONE, "m/s|rad/s",
     "normal velocity before"},
    {"/impact/velocity_after", FIELD(impact.velocity_after), NSDAE_WIDTH_ONE, "m/s|rad/s",
     "normal velocity after"},
    {"/impact/peak_force", FIELD(impact.peak_force), NSDAE_WIDTH_ONE, "N|N m",
     "largest normal force of a continuous contact; 0 for a rigid one"},
    {"/impact/accumulation", INT_FIELD(impact.accumulation), NSDAE_WIDTH_ONE, "1",
     "1 where the entry stands for infinitely many impacts that end at its time in rest"},
};

static const nsdae_column change_columns[] = {
    {"/change/time", FIELD(change.time), NSDAE_WIDTH_ONE, "s", "instant of a change of mode"},
    {"/change/id", LONG_FIELD(change.id), NSDAE_WIDTH_ONE, "1",
     "id of the contact; -1: a frictional joint"},
    {"/change/block", INT_FIELD(change.block), NSDAE_WIDTH_PAIR, "1",
     "blocks of the contact; -1: the ground"},
    {"/change/frictional_joint", INT_FIELD(change.frictional_joint), NSDAE_WIDTH_ONE, "1",
     "frictional joint, from 0; -1: a contact"},
    {"/change/mode_before", INT_FIELD(change.mode_before), NSDAE_WIDTH_ONE, "1",
     "0 open, 1 slip, 2 stick"},
    {"/change/mode_after", INT_FIELD(change.mode_after), NSDAE_WIDTH_ONE, "1",
     "0 open, 1 slip, 2 stick"},
};

static const nsdae_column contact_columns[] = {
    {"/contacts/id", offsetof(nsdae_row, record.contacts.id), 1, NSDAE_VALUE_LONG, NSDAE_WIDTH_LIST,
     "1", "id of the contact, constant in time"},
    {"/contacts/block", INT_ROW(record.contacts.block), NSDAE_WIDTH_PAIR, "1",
     "blocks of the contact; -1: the ground"},
    {"/contacts/gap", ROW(record.contacts.gap), NSDAE_WIDTH_ONE, "m|rad",
     "normal distance, negative in overlap; of a contact list at the last evaluation"},
    {"/contacts/normal_impulse", ROW(record.contacts.normal_impulse), NSDAE_WIDTH_ONE, "N s|N m s",
     "normal impulse of the step that ends here"},
    {"/contacts/tangential_impulse", ROW(record.contacts.tangential_impulse), NSDAE_WIDTH_T, "N s",
     "tangential impulse of the step that ends here"},
    {"/contacts/mode", INT_ROW(record.contacts.mode), NSDAE_WIDTH_ONE, "1",
     "0 open, 1 slip, 2 stick"},
    {"/contacts/point", ROW(point), NSDAE_WIDTH_FORCE, "m",
     "midway between the surfaces; NaN of a contact without an impulse or of no solids"},
    {"/contacts/force", ROW(force), NSDAE_WIDTH_FORCE, "N",
     "on the body of the larger number, mean over the step that ends here"},
};

#define COLUMNS(column) column, (int)(sizeof(column) / sizeof *(column))

const nsdae_table nsdae_tables[NSDAE_TABLES] = {
    [NSDAE_RECORDS] = {COLUMNS(record_columns), "time", 1, 1, 0},
    [NSDAE_IMPACTS] = {COLUMNS(impact_columns), "impact time", 1, 0, 0},
    [NSDAE_CHANGES] = {COLUMNS(change_columns), "change time", 1, 0, 0},
    [NSDAE_CONTACTS] = {COLUMNS(contact_columns), "id", 0, 1, 1},
};

/* The number of values of sensor i if it has a name, else 0; -1: there is none. */
static int named_sensor(const nsdae_system *system, int i)
{
  int size = nsdae_system_sensor_size(system, i);
  if (size == 0) return -1;
  return *nsdae_system_get_name(system, NSDAE_NAME_SENSOR, i) ? size : 0;
}

nsdae_sizes nsdae_sizes_of(const nsdae_sim *sim, int forces)
{
  nsdae_dims d;
  int varies = nsdae_sim_get_system(sim)->call.contacts != NULL;
  nsdae_sim_get_dims(sim, &d);
  int components[NSDAE_VALUES_MAX + 1] = {[3] = forces ? 3 : 0};
  for (int i = 0, size; (size = named_sensor(nsdae_sim_get_system(sim), i)) >= 0; i++)
    components[size] = size;
  return (nsdae_sizes){.axis = {d.nq, d.nv, d.m, d.k, d.k > 0 || varies ? d.nt : 0, d.f, 2 * varies,
                                components[2], components[3], components[4]},
                       .potential = nsdae_sim_has_potential(sim),
                       .varies = varies,
                       .forces = forces};
}

int nsdae_table_shape(const nsdae_table *table, nsdae_width width, const nsdae_sizes *sizes,
                      int shape[2], int axis[2])
{
  const int *length = sizes->axis, varies = sizes->varies;
  const int one[] = {[NSDAE_WIDTH_ONE] = 1,
                     [NSDAE_WIDTH_POTENTIAL] = sizes->potential,
                     [NSDAE_WIDTH_LIST] = varies,
                     [NSDAE_WIDTH_CONTACTS] = varies || length[NSDAE_WIDTH_K] > 0,
                     [NSDAE_WIDTH_CONSTRAINTS] = length[NSDAE_WIDTH_M] > 0,
                     [NSDAE_WIDTH_FORCE] = sizes->forces};
  int rank = 0;
  shape[0] = shape[1] = 1;
  if (table->by_contact && !varies) axis[rank++] = NSDAE_WIDTH_K;
  if (width < NSDAE_AXES) axis[rank++] = (int)width;
  if (width == NSDAE_WIDTH_FORCE) axis[rank++] = NSDAE_WIDTH_THREE;
  for (int i = 0; i < rank; i++) shape[i] = length[axis[i]];
  if (width >= NSDAE_AXES) shape[1] *= one[width];
  return rank;
}

int nsdae_table_chunk(const nsdae_table *table, const nsdae_sizes *sizes)
{
  return table->by_contact && sizes->varies ? CONTACTS : ROWS;
}

int nsdae_contact_rows(const nsdae_record *r)
{
  return r->gap ? r->contacts.count > 0 : r->contacts.count;
}

/* Sensors as data sets of a trajectory. */

enum { PATH = sizeof "/sensor/" + NSDAE_NAME_SIZE };

int nsdae_sensor_columns_init(nsdae_sensor_columns *c, const nsdae_sim *sim)
{
  static const nsdae_width width[] = {0, NSDAE_WIDTH_ONE, NSDAE_WIDTH_TWO, NSDAE_WIDTH_THREE,
                                      NSDAE_WIDTH_FOUR};
  const nsdae_system *system = nsdae_sim_get_system(sim);
  const nsdae_table *records = &nsdae_tables[NSDAE_RECORDS];
  size_t known = (size_t)records->columns, count = 0;
  while (named_sensor(system, (int)count) >= 0) count++;
  c->column = malloc((known + count) * sizeof *c->column);
  c->path = malloc(count * PATH + 1);
  c->row = malloc(sizeof *c->row + count * NSDAE_VALUES_MAX * sizeof(double));
  if (!c->column || !c->path || !c->row) return NSDAE_E_MEMORY;
  c->table = *records;
  c->table.column = c->column;
  memcpy(c->column, records->column, known * sizeof *c->column);
  for (size_t i = 0; i < count; i++) {
    int size = named_sensor(system, (int)i);
    char *path = c->path + i * PATH;
    if (size == 0) continue;
    snprintf(path, PATH, "/sensor/%s", nsdae_system_get_name(system, NSDAE_NAME_SENSOR, (int)i));
    c->column[c->table.columns++] =
        (nsdae_column){.path = path,
                       .offset = sizeof *c->row + i * NSDAE_VALUES_MAX * sizeof(double),
                       .value = NSDAE_VALUE_REAL,
                       .width = width[size],
                       .units = nsdae_system_get_unit(system, NSDAE_NAME_SENSOR, (int)i),
                       .description = "sensor of the model; forces and accelerations are means "
                                      "over the step that ends here"};
  }
  return NSDAE_OK;
}

void nsdae_sensor_columns_release(nsdae_sensor_columns *c)
{
  free(c->column);
  free(c->path);
  free(c->row);
  *c = (nsdae_sensor_columns){0};
}

int nsdae_sensor_columns_read(nsdae_sensor_columns *c, nsdae_sim *sim)
{
  const nsdae_system *system = nsdae_sim_get_system(sim);
  double *value = (double *)(c->row + 1);
  int status = NSDAE_OK;
  for (int i = 0, size; (size = named_sensor(system, i)) >= 0 && status == NSDAE_OK; i++)
    if (size > 0) status = nsdae_sim_get_sensor(sim, i, value + i * NSDAE_VALUES_MAX);
  return status;
}
