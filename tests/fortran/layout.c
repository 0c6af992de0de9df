/* What the headers say of values, sizes and places, for the module to be compared with. */
#include "layout.h"

#include <nsdae/nsdae.h>
#include <stddef.h>
#include <string.h>

typedef struct entry {
  const char *name;
  long value;
} entry;

#define STATUS(name, value, message) {#name, name},
#define VALUE(name)                  {#name, name},
#define SIZE(type)                   {#type, (long)sizeof(type)},
#define AT(type, field)              {#type "%" #field, (long)offsetof(type, field)},

static const entry entries[] = {
    NSDAE_STATUS_LIST(STATUS)
    /* clang-format off */
    VALUE(NSDAE_VERSION_MAJOR) VALUE(NSDAE_VERSION_MINOR) VALUE(NSDAE_VERSION_PATCH)
    VALUE(NSDAE_METHOD_IMPLICIT) VALUE(NSDAE_METHOD_IMPLICIT_PRINTED) VALUE(NSDAE_METHOD_MOREAU)
    VALUE(NSDAE_METHOD_PENALTY) VALUE(NSDAE_METHOD_EVENT) VALUE(NSDAE_PENALTY_HERTZ)
    VALUE(NSDAE_PENALTY_KELVIN_VOIGT) VALUE(NSDAE_PENALTY_HUNT_CROSSLEY)
    VALUE(NSDAE_PENALTY_LANKARANI_NIKRAVESH) VALUE(NSDAE_PENALTY_FLORES) VALUE(NSDAE_LINEAR_DENSE) VALUE(NSDAE_LINEAR_SPARSE)
    VALUE(NSDAE_REDUNDANT_ERROR) VALUE(NSDAE_REDUNDANT_LEAST_NORM)
    VALUE(NSDAE_MODE_OPEN) VALUE(NSDAE_MODE_SLIDE) VALUE(NSDAE_MODE_STICK) VALUE(NSDAE_OBSERVERS_MAX)
    VALUE(NSDAE_PROJECTION_NONE) VALUE(NSDAE_PROJECTION_CONSTRAINTS) VALUE(NSDAE_PROJECTION_CONTACTS)
    VALUE(NSDAE_NAME_COORDINATE) VALUE(NSDAE_NAME_VELOCITY) VALUE(NSDAE_NAME_CONSTRAINT)
    VALUE(NSDAE_NAME_CONTACT) VALUE(NSDAE_NAME_SLIDE) VALUE(NSDAE_NAME_SIZE) VALUE(NSDAE_UNIT_SIZE)
    VALUE(NSDAE_PARAM_REAL) VALUE(NSDAE_PARAM_INT) VALUE(NSDAE_PARAM_CHOICE)
    VALUE(NSDAE_PARAM_TEXT) VALUE(NSDAE_PARAM_TEXT_SIZE)
    VALUE(NSDAE_OPEN_MIN) VALUE(NSDAE_OPEN_MAX)
    VALUE(NSDAE_LCP_NONE) VALUE(NSDAE_LCP_TRIVIAL) VALUE(NSDAE_LCP_WARM) VALUE(NSDAE_LCP_LEMKE)
    VALUE(NSDAE_LCP_NEWTON) VALUE(NSDAE_LCP_COVERING) VALUE(NSDAE_LCP_PROVE) VALUE(NSDAE_LCP_FURTHER)
    VALUE(NSDAE_LCP_ENUMERATE) VALUE(NSDAE_LCP_ALL)
    VALUE(NSDAE_OUTCOME_UNSOLVED) VALUE(NSDAE_OUTCOME_SOLVED) VALUE(NSDAE_OUTCOME_INFEASIBLE)
    VALUE(NSDAE_PROOF_NONE) VALUE(NSDAE_PROOF_FARKAS) VALUE(NSDAE_PROOF_ENUMERATED)
    VALUE(NSDAE_LCP_RAY_NOTHING) VALUE(NSDAE_LCP_RAY_NOT_COPOSITIVE)
    VALUE(NSDAE_LCP_RAY_NOT_STRICTLY_COPOSITIVE)
    VALUE(NSDAE_FRICTION_GLOBAL)
    VALUE(NSDAE_FRICTION_LOCAL)
    VALUE(NSDAE_FRICTION_NONE)
    VALUE(NSDAE_FRICTION_TRIVIAL)
    VALUE(NSDAE_FRICTION_WARM)
    VALUE(NSDAE_FRICTION_GAUSS_SEIDEL)
    VALUE(NSDAE_FRICTION_SMOOTHING)
    VALUE(NSDAE_FRICTION_FURTHER)
    VALUE(NSDAE_FRICTION_ALL)

    SIZE(nsdae_error)
    AT(nsdae_error, code) AT(nsdae_error, index) AT(nsdae_error, time)
    AT(nsdae_error, argument) AT(nsdae_error, where) AT(nsdae_error, text)
    SIZE(nsdae_dims)
    AT(nsdae_dims, nv) AT(nsdae_dims, m) AT(nsdae_dims, k) AT(nsdae_dims, nt) AT(nsdae_dims, f)
    SIZE(nsdae_check)
    AT(nsdae_check, row) AT(nsdae_check, column) AT(nsdae_check, given)
    AT(nsdae_check, difference) AT(nsdae_check, error)
    SIZE(nsdae_param)
    AT(nsdae_param, unit) AT(nsdae_param, help) AT(nsdae_param, type) AT(nsdae_param, offset)
    AT(nsdae_param, initial) AT(nsdae_param, min) AT(nsdae_param, max) AT(nsdae_param, open)
    AT(nsdae_param, choices)
    SIZE(nsdae_params) AT(nsdae_params, n)
    SIZE(nsdae_sim_options)
    AT(nsdae_sim_options, dt) AT(nsdae_sim_options, baumgarte_alpha)
    AT(nsdae_sim_options, baumgarte_beta) AT(nsdae_sim_options, iteration_tol)
    AT(nsdae_sim_options, iteration_max) AT(nsdae_sim_options, redundant)
    AT(nsdae_sim_options, rank_tol) AT(nsdae_sim_options, lcp_tol)
    AT(nsdae_sim_options, polygon) AT(nsdae_sim_options, impact_velocity)
    AT(nsdae_sim_options, rtol) AT(nsdae_sim_options, atol) AT(nsdae_sim_options, penalty_law)
    AT(nsdae_sim_options, penalty_stiffness) AT(nsdae_sim_options, penalty_exponent)
    AT(nsdae_sim_options, friction_velocity) AT(nsdae_sim_options, linear_solver)
    AT(nsdae_sim_options, accumulation_time) AT(nsdae_sim_options, events_max)
        AT(nsdae_sim_options, inner_steps_max)
    AT(nsdae_sim_options, projection) AT(nsdae_sim_options, start_tol)
    AT(nsdae_sim_options, initialised)
    SIZE(nsdae_impact)
    AT(nsdae_impact, contact) AT(nsdae_impact, normal_impulse)
    AT(nsdae_impact, tangential_impulse) AT(nsdae_impact, velocity_before)
    AT(nsdae_impact, velocity_after) AT(nsdae_impact, peak_force)
    AT(nsdae_impact, accumulation)
    SIZE(nsdae_change)
    AT(nsdae_change, contact) AT(nsdae_change, slide) AT(nsdae_change, mode_before)
    AT(nsdae_change, mode_after)
    SIZE(nsdae_record)
    AT(nsdae_record, time) AT(nsdae_record, q) AT(nsdae_record, v) AT(nsdae_record, multiplier)
    AT(nsdae_record, gap) AT(nsdae_record, normal_impulse) AT(nsdae_record, tangential_impulse)
    AT(nsdae_record, mode) AT(nsdae_record, slide_impulse) AT(nsdae_record, slide_mode)
    AT(nsdae_record, kinetic) AT(nsdae_record, potential) AT(nsdae_record, dissipated)
    AT(nsdae_record, lcp_residual) AT(nsdae_record, constraint_drift)
    AT(nsdae_record, penetration) AT(nsdae_record, impact) AT(nsdae_record, impacts)
    AT(nsdae_record, change) AT(nsdae_record, changes)
    SIZE(nsdae_stats)
    AT(nsdae_stats, smooth_steps) AT(nsdae_stats, contact_steps) AT(nsdae_stats, lcps)
    AT(nsdae_stats, lcp_pivots) AT(nsdae_stats, iterations) AT(nsdae_stats, mass_evals)
    AT(nsdae_stats, force_evals) AT(nsdae_stats, jacobian_evals) AT(nsdae_stats, impacts)
    AT(nsdae_stats, events) AT(nsdae_stats, accumulations) AT(nsdae_stats, fallback_steps)
    AT(nsdae_stats, rank) AT(nsdae_stats, rank_most)
    AT(nsdae_stats, worst_residual) AT(nsdae_stats, worst_drift)
    AT(nsdae_stats, worst_penetration) AT(nsdae_stats, energy_start)
    AT(nsdae_stats, energy_balance) AT(nsdae_stats, warnings) AT(nsdae_stats, wall_time)
    SIZE(nsdae_trajectory_info)
    AT(nsdae_trajectory_info, parameters) AT(nsdae_trajectory_info, parameters_base)
    AT(nsdae_trajectory_info, live) AT(nsdae_trajectory_info, every)
    AT(nsdae_trajectory_info, compress) AT(nsdae_trajectory_info, t_end)
    SIZE(nsdae_lcp_problem)
    AT(nsdae_lcp_problem, A) AT(nsdae_lcp_problem, lda) AT(nsdae_lcp_problem, b)
    SIZE(nsdae_lcp_options)
    AT(nsdae_lcp_options, max_pivots) AT(nsdae_lcp_options, stages)
    AT(nsdae_lcp_options, enumerate_max)
    SIZE(nsdae_lcp_info)
    AT(nsdae_lcp_info, stage) AT(nsdae_lcp_info, proof) AT(nsdae_lcp_info, ray)
    AT(nsdae_lcp_info, pivots) AT(nsdae_lcp_info, residual)
    SIZE(nsdae_lcp_origin)
    AT(nsdae_lcp_origin, step) AT(nsdae_lcp_origin, tol) AT(nsdae_lcp_origin, method)
    SIZE(nsdae_lcp_file)
    AT(nsdae_lcp_file, A) AT(nsdae_lcp_file, b) AT(nsdae_lcp_file, tol)
    SIZE(nsdae_friction_problem)
    AT(nsdae_friction_problem, contacts)
    AT(nsdae_friction_problem, bilateral)
    AT(nsdae_friction_problem, rows)
    AT(nsdae_friction_problem, mu)
    AT(nsdae_friction_problem, w)
    AT(nsdae_friction_problem, compliance)
    AT(nsdae_friction_problem, blocks)
    AT(nsdae_friction_problem, size)
    AT(nsdae_friction_problem, M)
    AT(nsdae_friction_problem, f)
    AT(nsdae_friction_problem, first)
    AT(nsdae_friction_problem, block)
    AT(nsdae_friction_problem, value)
    SIZE(nsdae_friction_options)
    AT(nsdae_friction_options, stages)
    AT(nsdae_friction_options, max_sweeps)
    AT(nsdae_friction_options, max_iterations)
    SIZE(nsdae_friction_info)
    AT(nsdae_friction_info, stage)
    AT(nsdae_friction_info, proof)
    AT(nsdae_friction_info, islands)
    AT(nsdae_friction_info, sweeps)
    AT(nsdae_friction_info, iterations)
    AT(nsdae_friction_info, factorisations)
    AT(nsdae_friction_info, residual)
    /* clang-format on */
};

enum { COUNT = sizeof entries / sizeof *entries };

int layout_count(void)
{
  return COUNT;
}

long layout_value(const char *name)
{
  for (int i = 0; i < COUNT; i++)
    if (strcmp(entries[i].name, name) == 0) return entries[i].value;
  return LAYOUT_UNKNOWN;
}
