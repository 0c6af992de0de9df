// nsdae_sim with its records as arrays.
#ifndef NSDAE_PYTHON_SIM_HPP
#define NSDAE_PYTHON_SIM_HPP

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include <nsdae/nsdae.h>

#include "system.hpp"
#include "view.hpp"

namespace nsdae_python
{

// Checks for Ctrl-C about twenty times a second, for any length of the steps.
class watch
{
public:
  static int asked(void *self);

private:
  using clock = std::chrono::steady_clock;
  int look();
  int left = 0, count = 1;
  clock::time_point last = clock::now();
};

// An impact and a mode transition as rows of structured arrays, with the fields of _records.py.
struct impact_row {
  double time;
  int contact, accumulation;
  double normal_impulse, tangential_impulse[2], velocity_before, velocity_after, peak_force;
  std::int64_t id; // of a contact list; number of a fixed contact
  int block[2];
};

// A contact of a record.
struct contact_row {
  std::int64_t id;
  int block[2];
  double gap, normal_impulse, tangential_impulse[2];
  int mode, nothing;
};

void append_contacts(std::vector<contact_row> &rows, const nsdae_contact_set &set, int nt);

// The same with its point and force.
struct contact_force_row {
  contact_row contact;
  double point[3], force[3];
};

struct change_row {
  double time;
  int contact, frictional_joint, mode_before, mode_after;
  std::int64_t id;
  int block[2];
};

// Records of a run, in columns.
struct columns {
  std::vector<double> time, q, v, acceleration, multiplier, frictional_joint_impulse, kinetic,
      potential, dissipated, projection_energy, lcp_residual, contact_tol, constraint_drift,
      penetration;
  std::vector<int> frictional_joint_mode, contact_count;
  std::vector<contact_row> contacts;
  std::vector<impact_row> impacts;
  std::vector<change_row> changes;
  std::vector<nsdae_certificate> certificates;
  bool listed = false;
  void add(const nsdae_record &r, const nsdae_dims &d);
  void add_events(const nsdae_record &r);
  nb::dict arrays(const nsdae_dims &d);
};

// A record of its own: the numbers are copied at once, a field becomes an object of Python when it
// is read. The pointers of `of` are those of the simulation, and not read.
struct kept_record {
  kept_record(const nsdae_record &r, const nsdae_dims &d);
  nsdae_record of;
  nsdae_dims dims;
  std::vector<double> q, v, acceleration, multiplier, frictional_joint_impulse;
  std::vector<int> frictional_joint_mode;
  columns events;
};

// Copies as arrays of NumPy.
nb::object numbers_from(const double *values, int n);
nb::object contacts_from(const std::vector<contact_row> &rows, int nt);

// Records of record_run; a separate object, so that a second thread does not share it.
struct recorder {
  columns kept;
  nsdae_sim *from = nullptr;
  std::vector<std::vector<double>> sensors; // of each sensor the values of all records
  bool contact_forces = false;
  std::vector<double> point, force; // [3] of each contact of all records, if contact_forces
  nsdae_dims dims = {};
  int every = 1;
  bool last_kept = true;
  PyObject *write = nullptr; // a function of Python that writes the records, or NULL
  std::chrono::steady_clock::time_point due;
  double pause = 0; // between two writes [s]
  bool written();
  int add(const nsdae_record &record);
  int add_forces(int contacts);
  nb::object contacts(); // with points and forces
  static int observe(const nsdae_record *record, nsdae_error *error, void *self);
  nb::dict arrays(); // of the records since the last call
};

// A simulation in Python. The library refuses concurrent calls. The same check is done here under
// the GIL, for the copies around a call: records and error texts.
class sim
{
public:
  sim(nb::object of, nb::dict options);
  ~sim();
  sim(const sim &) = delete;
  sim &operator=(const sim &) = delete;

  int init(double t0, vector q0, vector v0);
  nb::tuple project(double t0, vector q0, vector v0);
  int step();
  int run(double t_end, bool to_event);
  nb::str record_run(double t_end, int every, recorder &to, nb::object write, double pause,
                     bool contact_forces);
  kept_record record() const;
  double time() const;
  nb::object q() const;
  nb::object v() const;
  nb::object contacts() const;
  double dt() const;
  nsdae_record shown() const;
  nb::dict stats() const;
  nb::dict options() const;
  void set_options(nb::dict changes);
  void set_contact(int i, double mu, double e_n, double e_t);
  void set_frictional_joint(int j, double mu);
  void set_friction_bound(int j, double bound);
  void set_control(int i, double value);
  double get_control(int i);
  nb::object get_sensor(int i);
  nb::tuple contact_forces();
  nb::list sensors() const;
  nb::tuple interpolate(double t);
  nb::object failed_lcp() const;
  bool has_potential() const;
  bool started() const;
  nb::bytes state();
  void set_state(nb::bytes block);

  void release();

  nb::object owner; // the system
  nsdae_dims dims = {};

private:
  class use;
  void look() const;
  int checked(int status) const;
  void check_size(const char *name, vector a, int n) const;
  nsdae_sim *handle = nullptr;
  watch ctrl_c;
  bool in_call = false;
};

void bind_records(nb::module_ &m);
void bind_sim(nb::module_ &m);

} // namespace nsdae_python

#endif
