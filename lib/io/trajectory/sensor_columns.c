/* Sensors as data sets of a trajectory. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "trajectory_impl.h"

enum { PATH = sizeof "/sensor/" + NSDAE_NAME_SIZE };

int nsdae_sensor_columns_init(nsdae_sensor_columns *c, const nsdae_sim *sim)
{
  static const nsdae_width width[] = {0, NSDAE_WIDTH_ONE, NSDAE_WIDTH_TWO, NSDAE_WIDTH_THREE,
                                      NSDAE_WIDTH_FOUR};
  const nsdae_system *system = nsdae_sim_get_system(sim);
  const nsdae_table *records = &nsdae_tables[NSDAE_RECORDS];
  size_t known = (size_t)records->columns, count = 0;
  while (nsdae_named_sensor(system, (int)count) >= 0) count++;
  c->column = malloc((known + count) * sizeof *c->column);
  c->path = malloc(count * PATH + 1);
  c->row = malloc(sizeof *c->row + count * NSDAE_VALUES_MAX * sizeof(double));
  if (!c->column || !c->path || !c->row) return NSDAE_E_MEMORY;
  c->table = *records;
  c->table.column = c->column;
  memcpy(c->column, records->column, known * sizeof *c->column);
  for (size_t i = 0; i < count; i++) {
    int size = nsdae_named_sensor(system, (int)i);
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
  for (int i = 0, size; (size = nsdae_named_sensor(system, i)) >= 0 && status == NSDAE_OK; i++)
    if (size > 0) status = nsdae_sim_get_sensor(sim, i, value + i * NSDAE_VALUES_MAX);
  return status;
}
