#include "table.h"

#include <stddef.h>

#define FIELD(field)   offsetof(nsdae_record, field), 0, 0
#define ROW(field)     offsetof(nsdae_record, field), 1, 0
#define INT_ROW(field) offsetof(nsdae_record, field), 1, 1

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
    {"/contact/mode", INT_ROW(mode), NSDAE_WIDTH_K, "1", "0 open, 1 slide, 2 stick"},
    {"/slide/impulse", ROW(slide_impulse), NSDAE_WIDTH_F, "N s",
     "friction impulse on each bilateral constraint with friction, of the step that ends here"},
    {"/slide/mode", INT_ROW(slide_mode), NSDAE_WIDTH_F, "1", "0 frictionless, 1 slide, 2 stick"},
    {"/energy/kinetic", FIELD(kinetic), NSDAE_WIDTH_ONE, "J", "v^T M v / 2"},
    {"/energy/potential", FIELD(potential), NSDAE_WIDTH_ONE, "J",
     "potential energy of the model; zero where it gives none"},
    {"/energy/dissipated", FIELD(dissipated), NSDAE_WIDTH_ONE, "J",
     "work taken by contact and friction impulses so far"},
    {"/certificate/lcp_residual", FIELD(lcp_residual), NSDAE_WIDTH_ONE, "1",
     "scaled natural residual of the step's complementarity problem"},
    {"/certificate/constraint_drift", FIELD(constraint_drift), NSDAE_WIDTH_ONE, "of the model",
     "max |Phi|"},
    {"/certificate/penetration", FIELD(penetration), NSDAE_WIDTH_ONE, "m",
     "largest overlap over the contacts"},
};

const nsdae_table nsdae_record_table = {record_columns,
                                        (int)(sizeof record_columns / sizeof *record_columns)};

#undef FIELD
#define FIELD(field) offsetof(nsdae_impact, field), 0

static const nsdae_column impact_columns[] = {
    {"/impact/time", FIELD(time), 0, NSDAE_WIDTH_ONE, "s",
     "time of the impact; with a time-stepping method the end of its step"},
    {"/impact/contact", FIELD(contact), 1, NSDAE_WIDTH_ONE, "1", "contact, from 0"},
    {"/impact/normal_impulse", FIELD(normal_impulse), 0, NSDAE_WIDTH_ONE, "N s", "normal impulse"},
    {"/impact/tangential_impulse", FIELD(tangential_impulse), 0, NSDAE_WIDTH_T, "N s",
     "tangential impulse"},
    {"/impact/velocity_before", FIELD(velocity_before), 0, NSDAE_WIDTH_ONE, "m/s",
     "normal velocity before"},
    {"/impact/velocity_after", FIELD(velocity_after), 0, NSDAE_WIDTH_ONE, "m/s",
     "normal velocity after"},
    {"/impact/peak_force", FIELD(peak_force), 0, NSDAE_WIDTH_ONE, "N",
     "largest normal force of a continuous contact; 0 for a rigid one"},
    {"/impact/accumulation", FIELD(accumulation), 1, NSDAE_WIDTH_ONE, "1",
     "1 where the entry stands for infinitely many impacts that end at its time in rest"},
};

const nsdae_table nsdae_impact_table = {impact_columns,
                                        (int)(sizeof impact_columns / sizeof *impact_columns)};

#undef FIELD
#define FIELD(field) offsetof(nsdae_change, field), 0

static const nsdae_column change_columns[] = {
    {"/change/time", FIELD(time), 0, NSDAE_WIDTH_ONE, "s", "instant of a change of mode"},
    {"/change/contact", FIELD(contact), 1, NSDAE_WIDTH_ONE, "1", "contact, from 0; -1: a slide"},
    {"/change/slide", FIELD(slide), 1, NSDAE_WIDTH_ONE, "1", "slide, from 0; -1: a contact"},
    {"/change/mode_before", FIELD(mode_before), 1, NSDAE_WIDTH_ONE, "1",
     "0 open, 1 slide, 2 stick"},
    {"/change/mode_after", FIELD(mode_after), 1, NSDAE_WIDTH_ONE, "1", "0 open, 1 slide, 2 stick"},
};

const nsdae_table nsdae_change_table = {change_columns,
                                        (int)(sizeof change_columns / sizeof *change_columns)};

int nsdae_width_shape(nsdae_width width, const nsdae_dims *dims, int shape[2])
{
  const int one[] = {
      [NSDAE_WIDTH_Q] = dims->nq, [NSDAE_WIDTH_V] = dims->nv, [NSDAE_WIDTH_M] = dims->m,
      [NSDAE_WIDTH_K] = dims->k,  [NSDAE_WIDTH_KT] = dims->k, [NSDAE_WIDTH_T] = dims->nt,
      [NSDAE_WIDTH_F] = dims->f};
  shape[0] = shape[1] = 1;
  if (width == NSDAE_WIDTH_ONE) return 0;
  shape[0] = one[width];
  if (width != NSDAE_WIDTH_KT) return 1;
  shape[1] = dims->nt;
  return 2;
}
