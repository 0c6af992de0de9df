// nsdae_bodies with drives and loads of Python.
#ifndef NSDAE_PYTHON_BODIES_HPP
#define NSDAE_PYTHON_BODIES_HPP

#include <array>
#include <deque>
#include <string>

#include <nsdae/nsdae.h>

#include "callbacks.hpp"
#include "system.hpp"
#include "view.hpp"

namespace nsdae_python
{

using triple = std::array<double, 3>;
using quadruple = std::array<double, 4>;

class bodies
{
public:
  explicit bodies(int given);
  ~bodies();
  bodies(const bodies &) = delete;
  bodies &operator=(const bodies &) = delete;

  int add(double mass, triple inertia, triple product, triple position, double angle,
          quadruple quaternion, triple velocity, triple spin);
  int add_joint(int kind, int body0, int body1, triple point, triple end, triple axis, triple cross,
                double ratio, double mu, double radius, bool collide_connected, nb::object drive,
                std::uintptr_t address, std::uintptr_t user);
  int add_limit(int joint, int coordinate, double low, double high, double e_n);
  int add_rope(int body0, int body1, triple point, triple end, double length, double e_n);
  int add_coupler(std::array<int, 2> joint, std::array<int, 2> coordinate,
                  std::array<double, NSDAE_COUPLER_COEFFICIENTS> p);
  int add_motor(int joint, int coordinate, int kind, double target, double limit, double kp,
                double kd, nb::object drive, std::uintptr_t address, std::uintptr_t user,
                nb::object vary, std::uintptr_t vary_address, std::uintptr_t vary_user);
  int add_joint_spring(int joint, int coordinate, double stiffness, double damping, double rest);
  int add_sensor(const std::string &name, int kind, int body, int joint, int coordinate,
                 std::array<int, 2> solid, triple point);
  int add_spring(int body0, int body1, triple point, triple end, double stiffness, double damping,
                 double rest);
  int add_torsion(int body0, int body1, triple axis, double stiffness, double damping, double rest);
  int add_load(int body, triple point, nb::object load, std::uintptr_t address,
               std::uintptr_t user);
  int add_solid(int body, nb::dict solid);
  int add_contact(int solid0, int solid1, double mu, double e_n, double e_t);
  void set_pair(int material0, int material1, double mu, double e_n, double e_t);
  void set_gravity(triple g);
  void set_name(int kind, int i, const std::string &name);
  void set_colour(int kind, int i, const std::string &colour);
  int material(const std::string &name);
  // Sizes nq, nv, m, k, f; callbacks: name, function or None, address, user.
  void set_user_rows(std::array<int, 5> sizes, nb::list callbacks);
  nb::dict add_scene(const std::string &path);
  static nb::tuple make_system(nb::object self);
  nb::tuple start() const;
  triple locate(vector q, int body, triple local) const;

  const int dimension;
  nsdae_bodies *handle = nullptr;
  std::deque<callback> functions; // their addresses stay
  role_table own;                 // callbacks of the user rows

private:
  int demand(int status) const;
  void set_drive(nb::object function, std::uintptr_t address, std::uintptr_t given,
                 nsdae_drive_fn &drive, void *&user);
  bool listed = false; // contact list
  partition blocks;    // of the lists of user rows
};

void bind_bodies(nb::module_ &m);

} // namespace nsdae_python

#endif
