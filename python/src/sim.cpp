#include "sim.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include <nanobind/stl/string.h>

#include "failure.hpp"

namespace nsdae_python
{

namespace
{

void set_option(nsdae_sim_options &options, const std::string &key, const std::string &value)
{
  nsdae_error error;
  const char *name = text(key, "option");
  check(nsdae_sim_options_set(&options, name, text(value, name), &error), &error);
}

void set_options_of(nsdae_sim_options &options, nb::dict changes)
{
  for (auto [key, value] : changes)
    set_option(options, nb::cast<std::string>(key), nb::cast<std::string>(nb::str(value)));
}

void append(std::vector<double> &to, const double *values, int n)
{
  if (n > 0) to.insert(to.end(), values, values + n);
}

} // namespace

int watch::asked(void *self)
{
  watch *w = static_cast<watch *>(self);
  if (library_call::ending()) return 1;
  return --w->left > 0 ? 0 : w->look();
}

// The number of calls between two readings of the clock follows their speed. Python is checked at
// most every 50 ms, because this takes the GIL.
int watch::look()
{
  const auto now = clock::now();
  const auto since = now - last;
  using std::chrono::milliseconds;
  if (since < milliseconds(10))
    count = std::min(2 * count, 1 << 20);
  else if (since > milliseconds(50))
    count = std::max(count / 2, 1);
  left = count;
  if (since < milliseconds(50)) return 0;
  last = now;
  nb::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() == 0) return 0;
  remember_exception();
  return 1;
}

namespace
{

// Contacts of a list have no number.
bool is_listed(const nsdae_record &r)
{
  return !r.gap;
}

impact_row row_of(const nsdae_impact &p, bool listed)
{
  return {p.time,
          listed ? -1 : p.contact,
          p.accumulation,
          p.normal_impulse,
          {p.tangential_impulse[0], p.tangential_impulse[1]},
          p.velocity_before,
          p.velocity_after,
          p.peak_force,
          p.id,
          {p.block[0], p.block[1]}};
}

} // namespace

void columns::add_events(const nsdae_record &r)
{
  const bool list = is_listed(r);
  for (int i = 0; i < r.impacts; i++) impacts.push_back(row_of(r.impact[i], list));
  for (int i = 0; i < r.changes; i++) {
    const nsdae_change &c = r.change[i];
    changes.push_back({c.time,
                       list ? -1 : c.contact,
                       c.frictional_joint,
                       c.mode_before,
                       c.mode_after,
                       c.id,
                       {c.block[0], c.block[1]}});
  }
}

void append_contacts(std::vector<contact_row> &rows, const nsdae_contact_set &set, int nt)
{
  for (int i = 0; i < set.count; i++) {
    contact_row row = {set.id[i],  {set.block[2 * i], set.block[2 * i + 1]},
                       set.gap[i], set.normal_impulse[i],
                       {},         set.mode[i],
                       0};
    if (nt > 0)
      std::copy(set.tangential_impulse + i * nt, set.tangential_impulse + (i + 1) * nt,
                row.tangential_impulse);
    rows.push_back(row);
  }
}

void columns::add(const nsdae_record &r, const nsdae_dims &d)
{
  time.push_back(r.time);
  append(q, r.q, d.nq);
  append(v, r.v, d.nv);
  append(acceleration, r.acceleration, d.nv);
  append(multiplier, r.multiplier, d.m);
  append(frictional_joint_impulse, r.frictional_joint_impulse, d.f);
  if (d.f > 0)
    frictional_joint_mode.insert(frictional_joint_mode.end(), r.frictional_joint_mode,
                                 r.frictional_joint_mode + d.f);
  kinetic.push_back(r.kinetic);
  potential.push_back(r.potential);
  dissipated.push_back(r.dissipated);
  projection_energy.push_back(r.projection_energy);
  lcp_residual.push_back(r.lcp_residual);
  contact_tol.push_back(r.contact_tol);
  constraint_drift.push_back(r.constraint_drift);
  penetration.push_back(r.penetration);
  certificates.push_back(r.certificate);
  listed = is_listed(r);
  contact_count.push_back(r.contacts.count);
  append_contacts(contacts, r.contacts, d.nt);
}

namespace
{

// Rows of a struct as bytes [shape, size].
template <class T> nb::object bytes_of(const std::vector<T> &rows, std::vector<std::size_t> shape)
{
  const auto *first = reinterpret_cast<const std::uint8_t *>(rows.data());
  std::vector<std::uint8_t> copy(first, first + rows.size() * sizeof(T));
  shape.push_back(sizeof(T));
  return array_of(copy, shape);
}

template <class T> nb::object bytes_of(const std::vector<T> &rows)
{
  return bytes_of(rows, {rows.size()});
}

} // namespace

nb::dict columns::arrays(const nsdae_dims &d)
{
  const std::size_t n = time.size();
  const auto size = [](int i) { return static_cast<std::size_t>(i); };
  nb::dict a;
  a["impacts"] = bytes_of(impacts);
  a["changes"] = bytes_of(changes);
  a["contacts"] = listed ? bytes_of(contacts) : bytes_of(contacts, {n, size(d.k)});
  a["nt"] = d.nt;
  a["certificate"] = bytes_of(certificates);
  a["contact_count"] = array_of(contact_count, {n});
  a["q"] = array_of(q, {n, size(d.nq)});
  a["v"] = array_of(v, {n, size(d.nv)});
  a["acceleration"] = array_of(acceleration, {n, size(d.nv)});
  a["multiplier"] = array_of(multiplier, {n, size(d.m)});
  a["frictional_joint_impulse"] = array_of(frictional_joint_impulse, {n, size(d.f)});
  a["frictional_joint_mode"] = array_of(frictional_joint_mode, {n, size(d.f)});
  struct {
    const char *name;
    std::vector<double> &values;
  } scalars[] = {{"kinetic", kinetic},
                 {"potential", potential},
                 {"dissipated", dissipated},
                 {"projection_energy", projection_energy},
                 {"lcp_residual", lcp_residual},
                 {"contact_tol", contact_tol},
                 {"penetration", penetration},
                 {"constraint_drift", constraint_drift},
                 {"time", time}};
  for (auto &s : scalars) a[s.name] = array_of(s.values, {n});
  impacts.clear();
  changes.clear();
  contacts.clear();
  certificates.clear();
  return a;
}

sim::sim(nb::object of, nb::dict options) : owner(of)
{
  nsdae_sim_options told;
  nsdae_error error;
  nsdae_sim_options_default(&told);
  set_options_of(told, options);
  const system &s = nb::cast<const system &>(of);
  check(nsdae_sim_create(s.handle, &told, &handle, &error), &error);
  nsdae_sim_get_dims(handle, &dims);
  nsdae_sim_set_interrupt(handle, watch::asked, &ctrl_c);
}

sim::~sim()
{
  nsdae_sim_destroy(&handle);
}

// Clears a simulation in a garbage cycle; later calls are errors.
void sim::release()
{
  nsdae_sim_destroy(&handle);
  owner.reset();
}

void sim::look() const
{
  if (in_call)
    refuse(NSDAE_E_STATE, "sim",
           "another call on this simulation is in progress, in a callback or in another thread: "
           "call it before or after, or give each thread a Sim of its own");
}

// A call of the library, with the copies before and after it.
class sim::use
{
public:
  explicit use(sim &of) : s(of)
  {
    s.look();
    s.in_call = true;
  }
  ~use() { s.in_call = false; }
  use(const use &) = delete;
  use &operator=(const use &) = delete;

private:
  sim &s;
};

int sim::checked(int status) const
{
  check(status, nsdae_sim_error(handle));
  return status;
}

void sim::check_size(const char *name, vector a, int n) const
{
  if (a.shape(0) == static_cast<std::size_t>(n)) return;
  throw std::invalid_argument(std::string(name) + " has " + std::to_string(a.shape(0)) +
                              " numbers, not " + std::to_string(n));
}

int sim::init(double t0, vector q0, vector v0)
{
  use held(*this);
  check_size("q0", q0, dims.nq);
  check_size("v0", v0, dims.nv);
  int status;
  {
    library_call without_gil;
    status = nsdae_sim_init(handle, t0, q0.data(), v0.data());
  }
  return checked(status);
}

nb::tuple sim::project(double t0, vector q0, vector v0)
{
  use held(*this);
  check_size("q0", q0, dims.nq);
  check_size("v0", v0, dims.nv);
  std::vector<double> q(q0.data(), q0.data() + dims.nq), v(v0.data(), v0.data() + dims.nv);
  int status;
  {
    library_call without_gil;
    status = nsdae_sim_project(handle, t0, q.data(), v.data());
  }
  checked(status);
  return nb::make_tuple(array_of(q.data(), q.size()), array_of(v.data(), v.size()));
}

int sim::step()
{
  use held(*this);
  int status;
  {
    library_call without_gil;
    status = nsdae_sim_step(handle);
  }
  return checked(status);
}

int sim::run(double t_end, bool to_event)
{
  use held(*this);
  int status;
  {
    library_call without_gil;
    status = to_event ? nsdae_sim_run_to_event(handle, t_end) : nsdae_sim_run(handle, t_end);
  }
  return checked(status);
}

// Writes if it is due. False: an exception is pending.
bool recorder::written()
{
  using clock = std::chrono::steady_clock;
  if (clock::now() < due) return true;
  nb::gil_scoped_acquire gil;
  PyObject *result = PyObject_CallNoArgs(write);
  if (!result) remember_exception();
  Py_XDECREF(result);
  due = clock::now() +
        std::chrono::duration_cast<clock::duration>(std::chrono::duration<double>(pause));
  return result != nullptr;
}

// Of the contacts of the present record.
int recorder::add_forces(int contacts)
{
  const std::size_t before = point.size(), more = 3 * static_cast<std::size_t>(contacts);
  point.resize(before + more);
  force.resize(before + more);
  return nsdae_sim_get_contact_forces(from, point.data() + before, force.data() + before);
}

// A record with its sensors.
int recorder::add(const nsdae_record &record)
{
  const nsdae_system *system = nsdae_sim_get_system(from);
  double value[NSDAE_VALUES_MAX];
  int status = NSDAE_OK;
  kept.add(record, dims);
  for (int i = 0, size; (size = nsdae_system_sensor_size(system, i)) > 0; i++) {
    if (static_cast<std::size_t>(i) == sensors.size()) sensors.emplace_back();
    if (status == NSDAE_OK) status = nsdae_sim_get_sensor(from, i, value);
    sensors[static_cast<std::size_t>(i)].insert(sensors[static_cast<std::size_t>(i)].end(), value,
                                                value + size);
  }
  if (contact_forces && status == NSDAE_OK) status = add_forces(record.contacts.count);
  return status;
}

nb::object recorder::contacts()
{
  std::vector<contact_force_row> rows(kept.contacts.size());
  for (std::size_t i = 0; i < rows.size(); i++) {
    rows[i].contact = kept.contacts[i];
    std::copy_n(point.data() + 3 * i, 3, rows[i].point);
    std::copy_n(force.data() + 3 * i, 3, rows[i].force);
  }
  point.clear();
  force.clear();
  if (kept.listed) return bytes_of(rows);
  return bytes_of(rows, {kept.time.size(), static_cast<std::size_t>(dims.k)});
}

nb::dict recorder::arrays()
{
  const std::size_t n = kept.time.size();
  const nb::object pressed = contact_forces ? contacts() : nb::none();
  nb::dict a = kept.arrays(dims);
  if (contact_forces) a["contacts"] = pressed;
  nb::list all;
  for (std::size_t i = 0; i < sensors.size(); i++) {
    std::vector<double> &values = sensors[i];
    const auto size = static_cast<std::size_t>(
        nsdae_system_sensor_size(nsdae_sim_get_system(from), static_cast<int>(i)));
    all.append(size == 1 ? array_of(values, {n}) : array_of(values, {n, size}));
  }
  a["sensors"] = all;
  return a;
}

int recorder::observe(const nsdae_record *record, nsdae_error *error, void *self)
{
  recorder *r = static_cast<recorder *>(self);
  try {
    r->kept.add_events(*record);
    r->last_kept = record->step % r->every == 0;
    const int status = r->last_kept ? r->add(*record) : NSDAE_OK;
    if (status < 0) return status;
    if (r->last_kept && r->write && !r->written()) {
      snprintf(error->text, sizeof error->text, "the output was not written");
      return error->status = NSDAE_E_IO;
    }
  } catch (const std::bad_alloc &) {
    snprintf(error->text, sizeof error->text, "out of memory for the records");
    return error->status = NSDAE_E_MEMORY;
  }
  return 0;
}

// Keeps the start, each every-th record and the last one, also of a failed run. Returns the
// warnings, or "".
nb::str sim::record_run(double t_end, int every, recorder &to, nb::object write, double pause,
                        bool contact_forces)
{
  if (every < 1)
    refuse(NSDAE_E_ARGUMENT, "every", "every = " + std::to_string(every) + ": must be at least 1");
  use held(*this);
  to.dims = dims;
  to.every = every;
  to.write = write.is_none() ? nullptr : write.ptr();
  to.pause = pause;
  to.contact_forces = contact_forces;
  to.from = handle;
  checked(nsdae_sim_observe(handle, recorder::observe, &to));
  int status;
  try {
    library_call without_gil;
    status = nsdae_sim_run(handle, t_end);
  } catch (...) { // it did not start
    nsdae_sim_unobserve(handle, recorder::observe, &to);
    throw;
  }
  const nsdae_error error = *nsdae_sim_error(handle);
  nsdae_sim_unobserve(handle, recorder::observe, &to);
  to.write = nullptr;
  nsdae_record now;
  if (!to.last_kept && nsdae_sim_get_record(handle, &now) == NSDAE_OK) to.add(now);
  check(status, &error);
  return readable(error.status > 0 ? error.text : "");
}

// The library leaves the error of a constant simulation as it is.
nsdae_record sim::shown() const
{
  nsdae_record now;
  const int status = nsdae_sim_get_record(handle, &now);
  const nsdae_error *error = nsdae_sim_error(handle);
  if (status == NSDAE_E_STATE && error->status != status)
    refuse(status, "", "the simulation has no state: call nsdae_sim_init first");
  check(status, error);
  return now;
}

kept_record sim::record() const
{
  look();
  return kept_record(shown(), dims);
}

double sim::time() const
{
  look();
  return shown().time;
}

nb::object sim::q() const
{
  look();
  return numbers_from(shown().q, dims.nq);
}

nb::object sim::v() const
{
  look();
  return numbers_from(shown().v, dims.nv);
}

nb::object sim::contacts() const
{
  look();
  std::vector<contact_row> rows;
  append_contacts(rows, shown().contacts, dims.nt);
  return contacts_from(rows, dims.nt);
}

double sim::dt() const
{
  look();
  nsdae_sim_options now;
  check(nsdae_sim_get_options(handle, &now), nullptr);
  return now.dt;
}

nb::dict sim::stats() const
{
  look();
  nsdae_stats s;
  check(nsdae_sim_get_stats(handle, &s), nsdae_sim_error(handle));
  nb::dict d;
#define NSDAE_PYTHON_STAT(name) d[#name] = s.name;
  NSDAE_PYTHON_STAT(steps)
  NSDAE_PYTHON_STAT(smooth_steps)
  NSDAE_PYTHON_STAT(contact_steps)
  NSDAE_PYTHON_STAT(lcps)
  NSDAE_PYTHON_STAT(lcp_pivots)
  NSDAE_PYTHON_STAT(iterations)
  NSDAE_PYTHON_STAT(mass_evals)
  NSDAE_PYTHON_STAT(force_evals)
  NSDAE_PYTHON_STAT(jacobian_evals)
  NSDAE_PYTHON_STAT(impacts)
  NSDAE_PYTHON_STAT(events)
  NSDAE_PYTHON_STAT(accumulations)
  NSDAE_PYTHON_STAT(fallback_steps)
  NSDAE_PYTHON_STAT(inexact_steps)
  NSDAE_PYTHON_STAT(frozen_steps)
  NSDAE_PYTHON_STAT(accumulations_early)
  NSDAE_PYTHON_STAT(rank_retained)
  NSDAE_PYTHON_STAT(rank_discarded)
  NSDAE_PYTHON_STAT(rank)
  NSDAE_PYTHON_STAT(rank_most)
  NSDAE_PYTHON_STAT(worst_residual)
  NSDAE_PYTHON_STAT(contact_tol)
  NSDAE_PYTHON_STAT(worst_drift)
  NSDAE_PYTHON_STAT(worst_penetration)
  NSDAE_PYTHON_STAT(energy_start)
  NSDAE_PYTHON_STAT(energy_balance)
  NSDAE_PYTHON_STAT(warnings)
  NSDAE_PYTHON_STAT(wall_time)
  NSDAE_PYTHON_STAT(contact_capacity)
  NSDAE_PYTHON_STAT(contact_growths)
  NSDAE_PYTHON_STAT(islands)
  NSDAE_PYTHON_STAT(island_contacts)
#undef NSDAE_PYTHON_STAT
  d["certificate"] = bytes_of(std::vector<nsdae_certificate>{s.certificate});
  return d;
}

namespace
{

nb::object value_of(const nsdae_param &p, const nsdae_sim_options &options)
{
  const char *at = reinterpret_cast<const char *>(&options) + p.offset;
  char text[NSDAE_PARAM_TEXT_SIZE];
  if (p.type == NSDAE_PARAM_REAL) return nb::float_(*reinterpret_cast<const double *>(at));
  if (p.type == NSDAE_PARAM_INT) return nb::int_(*reinterpret_cast<const int *>(at));
  nsdae_params_format(&p, &options, text, sizeof text);
  return nb::str(text);
}

} // namespace

nb::dict sim::options() const
{
  look();
  nsdae_sim_options now;
  nb::dict d;
  check(nsdae_sim_get_options(handle, &now), nullptr);
  const nsdae_params *table = nsdae_sim_options_table();
  for (int i = 0; i < table->n; i++) d[table->entry[i].key] = value_of(table->entry[i], now);
  return d;
}

void sim::set_options(nb::dict changes)
{
  use held(*this);
  nsdae_sim_options now;
  check(nsdae_sim_get_options(handle, &now), nullptr);
  set_options_of(now, changes);
  checked(nsdae_sim_set_options(handle, &now));
}

void sim::set_contact(int i, double mu, double e_n, double e_t)
{
  use held(*this);
  checked(nsdae_sim_set_contact(handle, i, mu, e_n, e_t));
}

void sim::set_frictional_joint(int j, double mu)
{
  use held(*this);
  checked(nsdae_sim_set_frictional_joint(handle, j, mu));
}

void sim::set_friction_bound(int j, double bound)
{
  use held(*this);
  checked(nsdae_sim_set_friction_bound(handle, j, bound));
}

void sim::set_control(int i, double value)
{
  use held(*this);
  checked(nsdae_sim_set_control(handle, i, value));
}

double sim::get_control(int i)
{
  use held(*this);
  double value = 0;
  checked(nsdae_sim_get_control(handle, i, &value));
  return value;
}

nb::object sim::get_sensor(int i)
{
  use held(*this);
  double value[NSDAE_VALUES_MAX];
  checked(nsdae_sim_get_sensor(handle, i, value));
  const int size = nsdae_system_sensor_size(nsdae_sim_get_system(handle), i);
  return array_of(value, static_cast<std::size_t>(size));
}

nb::tuple sim::contact_forces()
{
  use held(*this);
  const std::size_t n = static_cast<std::size_t>(shown().contacts.count);
  std::vector<double> point(3 * n), force(3 * n);
  checked(nsdae_sim_get_contact_forces(handle, point.data(), force.data()));
  return nb::make_tuple(array_of(point.data(), 3 * n), array_of(force.data(), 3 * n));
}

// (name, unit) of each sensor.
nb::list sim::sensors() const
{
  const nsdae_system *system = nsdae_sim_get_system(handle);
  nb::list all;
  for (int i = 0; nsdae_system_sensor_size(system, i) > 0; i++)
    all.append(nb::make_tuple(nb::str(nsdae_system_get_name(system, NSDAE_NAME_SENSOR, i)),
                              nb::str(nsdae_system_get_unit(system, NSDAE_NAME_SENSOR, i))));
  return all;
}

nb::tuple sim::interpolate(double t)
{
  use held(*this);
  std::vector<double> q(static_cast<std::size_t>(dims.nq)), v(static_cast<std::size_t>(dims.nv));
  int status;
  {
    library_call without_gil;
    status = nsdae_sim_interpolate(handle, t, q.data(), v.data());
  }
  checked(status);
  return nb::make_tuple(array_of(q.data(), q.size()), array_of(v.data(), v.size()));
}

// (A, b), copied; None if the last step did not fail with one.
nb::object sim::failed_lcp() const
{
  look();
  nsdae_lcp_problem p;
  if (nsdae_sim_get_failed_lcp(handle, &p) != NSDAE_OK) return nb::none();
  const std::size_t n = static_cast<std::size_t>(p.n);
  double *A = new double[n * n + 1];
  for (std::size_t j = 0; j < n; j++)
    std::copy(p.A + j * static_cast<std::size_t>(p.lda),
              p.A + j * static_cast<std::size_t>(p.lda) + n, A + j * n);
  return nb::make_tuple(view(A, p.n, p.n, true), array_of(p.b, n));
}

bool sim::started() const
{
  look();
  nsdae_record now;
  return nsdae_sim_get_record(handle, &now) == NSDAE_OK;
}

bool sim::has_potential() const
{
  return nsdae_sim_has_potential(handle) == 1;
}

nb::bytes sim::state()
{
  use held(*this);
  std::size_t size = 0;
  checked(nsdae_sim_state_size(handle, &size));
  std::vector<char> block(size);
  checked(nsdae_sim_get_state(handle, block.data(), size));
  return nb::bytes(block.data(), size);
}

void sim::set_state(nb::bytes block)
{
  use held(*this);
  checked(nsdae_sim_set_state(handle, block.data(), block.size()));
}

namespace
{

int traverse(PyObject *self, visitproc visit, void *arg)
{
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self)) return 0;
  Py_VISIT(nb::inst_ptr<sim>(self)->owner.ptr());
  return 0;
}

int clear(PyObject *self)
{
  if (nb::inst_ready(self)) nb::inst_ptr<sim>(self)->release();
  return 0;
}

PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void *>(traverse)},
                       {Py_tp_clear, reinterpret_cast<void *>(clear)},
                       {0, nullptr}};

nb::list methods()
{
  nb::list names;
  for (int i = 0; nsdae_method_name(i); i++)
    names.append(nb::make_tuple(nsdae_method_name(i), nsdae_method_summary(i)));
  return names;
}

// float, int, or the choices; float or the word for zero.
nb::object kind_of(const nsdae_param &p)
{
  if (p.type == NSDAE_PARAM_REAL && p.choices)
    return nb::str((std::string("Union[float, Literal['") + p.choices[0] + "']]").c_str());
  if (p.type == NSDAE_PARAM_REAL) return nb::str("float");
  if (p.type == NSDAE_PARAM_INT) return nb::str("int");
  nb::list choices;
  for (int i = 0; p.choices[i]; i++) choices.append(nb::str(p.choices[i]));
  return nb::tuple(choices);
}

// Key, unit, help, range with default, and kind of every option.
nb::list option_table()
{
  nb::list rows;
  nsdae_sim_options defaults;
  nsdae_sim_options_default(&defaults);
  const nsdae_params *table = nsdae_sim_options_table();
  for (int i = 0; i < table->n; i++) {
    const nsdae_param &p = table->entry[i];
    char range[NSDAE_PARAM_TEXT_SIZE], value[NSDAE_PARAM_TEXT_SIZE];
    nsdae_params_range(&p, range, sizeof range);
    nsdae_params_format(&p, &defaults, value, sizeof value);
    rows.append(nb::make_tuple(p.key, p.unit, p.help, std::string(range) + ", default " + value,
                               kind_of(p)));
  }
  return rows;
}

} // namespace

void bind_sim(nb::module_ &m)
{
  m.attr("METHODS") = methods();
  m.attr("OPTIONS") = option_table();
  m.attr("IMPACT_SIZE") = sizeof(impact_row);
  m.attr("CHANGE_SIZE") = sizeof(change_row);
  m.attr("CERTIFICATE_SIZE") = sizeof(nsdae_certificate);
  m.attr("CONTACT_ROW_SIZE") = sizeof(contact_row);
  m.attr("CONTACT_FORCE_ROW_SIZE") = sizeof(contact_force_row);
  nb::class_<recorder>(m, "Recorder").def(nb::init<>()).def("arrays", &recorder::arrays);
  nb::class_<sim>(m, "Sim", nb::type_slots(slots))
      .def(nb::init<nb::object, nb::dict>())
      .def("init", &sim::init)
      .def("project", &sim::project)
      .def("step", &sim::step)
      .def("run", &sim::run)
      .def("record_run", &sim::record_run, nb::arg(), nb::arg(), nb::arg(), nb::arg().none(),
           nb::arg(), nb::arg())
      .def("record", &sim::record)
      .def("time", &sim::time)
      .def("q", &sim::q)
      .def("v", &sim::v)
      .def("contacts", &sim::contacts)
      .def("dt", &sim::dt)
      .def("stats", &sim::stats)
      .def("options", &sim::options)
      .def("set_options", &sim::set_options)
      .def("set_contact", &sim::set_contact)
      .def("set_frictional_joint", &sim::set_frictional_joint)
      .def("set_friction_bound", &sim::set_friction_bound)
      .def("set_control", &sim::set_control)
      .def("get_control", &sim::get_control)
      .def("get_sensor", &sim::get_sensor)
      .def("contact_forces", &sim::contact_forces)
      .def("sensors", &sim::sensors)
      .def("interpolate", &sim::interpolate)
      .def("failed_lcp", &sim::failed_lcp)
      .def("has_potential", &sim::has_potential)
      .def("started", &sim::started)
      .def("state", &sim::state)
      .def("set_state", &sim::set_state);
}

} // namespace nsdae_python
