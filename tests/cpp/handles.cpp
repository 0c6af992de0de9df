/* nsdae.hpp: the same bytes as C, errors, exceptions of callbacks, moves, lifetimes. */
#include <nsdae/nsdae.hpp>

#include <array>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "cpp_pendulum.h"

namespace
{

int failures = 0;

void expect(bool holds, const char *what, int line)
{
  if (holds) return;
  std::printf("handles.cpp:%d: not so: %s\n", line, what);
  failures++;
}

#define EXPECT(condition) expect((condition), #condition, __LINE__)

/* The exception of type E that call throws is handed to see. */
template <class E, class Call, class See> bool throws(Call call, See see)
{
  try {
    call();
  } catch (const E &exception) {
    return see(exception);
  } catch (...) {
  }
  return false;
}

template <class Call> bool throws_status(int status, Call call)
{
  return throws<nsdae::error>(call, [=](const nsdae::error &e) {
    return e.status() == status && e.record().status == status && *e.what();
  });
}

nsdae_dims sizes(int nq, int m, int k)
{
  nsdae_dims dims = nsdae_dims();
  dims.nq = nq;
  dims.m = m;
  dims.k = k;
  return dims;
}

/* One mass that falls on a floor. */
nsdae::system make_ball(double gravity = 9.81)
{
  nsdae::system ball(sizes(1, 0, 1));
  ball.mass([](double, const double *, double *M, int) { M[0] = 0.1; });
  ball.force([gravity](double, const double *, const double *, double *F) {
    F[0] = -0.1 * gravity;
    return 0;
  });
  ball.gap([](double, const double *q, double *g) { g[0] = q[0]; }).contact(0, 0, 0.5);
  return ball;
}

nsdae::system make_pendulum()
{
  nsdae::system rod(sizes(3, 2, 1));
  rod.mass([](double, const double *, double *M, int ldm) {
    M[0] = M[ldm + 1] = 4.9;
    M[2 * ldm + 2] = 4.9 / 12;
  });
  rod.force([](double, const double *, const double *, double *F) { F[1] = -4.9 * 9.8; });
  rod.constraint([](double, const double *q, double *phi) {
    phi[0] = q[0] - 0.5 * std::sin(q[2]);
    phi[1] = q[1] + 0.5 * std::cos(q[2]);
  });
  rod.constraint_jacobian([](double, const double *q, double *J, int ldj) {
    J[0] = J[ldj + 1] = 1;
    J[2 * ldj] = -0.5 * std::cos(q[2]);
    J[2 * ldj + 1] = -0.5 * std::sin(q[2]);
  });
  rod.constraint_bias([](double, const double *q, const double *v, double *, double *omega) {
    omega[0] = 0.5 * std::sin(q[2]) * v[2] * v[2];
    omega[1] = -0.5 * std::cos(q[2]) * v[2] * v[2];
  });
  rod.gap([](double, const double *q, double *g) { g[0] = std::sin(q[2]); });
  rod.contact(0, 0, 0.56);
  return rod;
}

void test_same_bytes()
{
  static double expected[PENDULUM_STEPS + 1][PENDULUM_ROW];
  static double row[PENDULUM_STEPS + 1][PENDULUM_ROW];
  double *next = row[0];
  nsdae::sim sim(make_pendulum()); /* which lives on in it */
  sim.init(0, std::array<double, 3>{{0.5 * std::sin(1.57), -0.5 * std::cos(1.57), 1.57}},
           std::vector<double>(3));
  sim.observe([&](const nsdae_record &now) {
    *next++ = now.time;
    for (int i = 0; i < 3; i++) *next++ = now.q[i];
    for (int i = 0; i < 3; i++) *next++ = now.v[i];
    for (int i = 0; i < 2; i++) *next++ = now.multiplier[i];
    *next++ = now.normal_impulse[0];
  });
  EXPECT(sim.run(0.005 * (PENDULUM_STEPS - 1)) == NSDAE_OK);
  EXPECT(next - row[0] == PENDULUM_STEPS * PENDULUM_ROW);
  EXPECT(pendulum_in_c(expected) == PENDULUM_STEPS);
  EXPECT(sim.stats().impacts >= 3);
  const nsdae_certificate figures = sim.record().certificate, all = sim.stats().certificate;
  EXPECT(figures.unexplained == all.unexplained && figures.unexplained != 0);
  EXPECT(all.constraint_rate > 0 && (all.rate_constraint == 0 || all.rate_constraint == 1));
  EXPECT(all.penetration == sim.stats().worst_penetration && all.penetration_contact == 0);
  EXPECT(std::memcmp(row, expected, sizeof row) == 0);
}

void test_errors()
{
  nsdae_error record = nsdae_error();
  nsdae::system none, unfinished(sizes(1, 0, 0));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [] { nsdae::system(sizes(0, 0, 0)); }));
  EXPECT(throws_status(NSDAE_E_STATE, [&] { nsdae::sim{unfinished}; }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { nsdae::sim{none}; }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { none.contact(0, 0, 0); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { make_ball().contact(1, 0, 0); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { make_ball().size(NSDAE_NAME_CONTACT, 1, 0.1); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] {
    unfinished.gap([](double, const double *, double *) {}); /* k = 0 */
  }));
  EXPECT(none.try_create(sizes(1, 0, -1), &record) == NSDAE_E_ARGUMENT && !none);
  EXPECT(std::strcmp(record.argument, "k") == 0);

  nsdae::sim sim(make_ball());
  EXPECT(throws_status(NSDAE_E_STATE, [&] { sim.record(); }));
  EXPECT(throws_status(NSDAE_E_STATE, [&] { sim.run(1); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.init(0, {1, 2}, {0}); }));
  EXPECT(throws_status(NSDAE_E_NONFINITE, [&] { sim.init(0, {std::nan("")}, {0}); }));
  EXPECT(sim.try_init(0, nullptr, nullptr) == NSDAE_E_ARGUMENT);
  EXPECT(sim.last_error()->status == NSDAE_E_ARGUMENT);
  EXPECT(sim.try_run(1) == NSDAE_E_STATE);
}

void test_options()
{
  nsdae::options options;
  options.set("dt", 0.1).set("method", "moreau").set("iteration_max", 7);
  EXPECT(options->dt == 0.1);                /* to the last bit */
  std::setlocale(LC_NUMERIC, "de_DE.UTF-8"); /* where it is installed */
  options.set("dt", 0.3);
  std::setlocale(LC_NUMERIC, "C");
  EXPECT(options.set("rtol", 1e-9)->dt == 0.3 && options->rtol == 1e-9);
  EXPECT(options->method == NSDAE_METHOD_MOREAU && options.c()->iteration_max == 7);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { options.set("dt", -1); }));
  EXPECT(throws<nsdae::error>([&] { options.set("metod", "moreau"); },
                              [](const nsdae::error &e) {
                                return e.status() == NSDAE_E_OPTION &&
                                       std::strstr(e.what(), "method");
                              }));
}

struct surprise {
  int number;
};

void test_exceptions()
{
  double until = 0.1;
  nsdae::system ball(make_ball());
  ball.force([&](double t, const double *, const double *, double *F) {
    if (t > until) throw surprise{42};
    F[0] = -1;
  });
  auto is_surprise = [](const surprise &s) { return s.number == 42; };
  nsdae::sim sim(ball);
  sim.init(0, {1}, {0});
  EXPECT(throws<surprise>([&] { sim.run(1); }, is_surprise));
  EXPECT(sim.last_error()->status == NSDAE_E_CALLBACK && sim.record().time <= until);
  EXPECT(!nsdae::take_exception()); /* it was thrown */

  EXPECT(sim.try_run(1) == NSDAE_E_CALLBACK);
  std::exception_ptr exception = nsdae::take_exception();
  EXPECT(exception && !nsdae::take_exception());
  EXPECT(throws<surprise>([&] { std::rethrow_exception(exception); }, is_surprise));

  EXPECT(sim.try_run(1) == NSDAE_E_CALLBACK); /* left untaken: not thrown by what did not do it */
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { ball.contact(7, 0, 0); }));
  until = 2;
  EXPECT(sim.run(1) == NSDAE_OK && sim.record().time == 1);

  until = -1;
  EXPECT(throws<surprise>([&] { sim.init(0, {1}, {0}); }, is_surprise));
  nsdae::system rod(make_pendulum());
  rod.constraint([](double, const double *, double *) { throw surprise{42}; });
  EXPECT(throws<surprise>([&] { rod.check(0, {0, 0, 0}, {0, 0, 0}); }, is_surprise));
}

void test_observers()
{
  nsdae::sim sim(make_ball());
  int seen = 0;
  sim.observe([&](const nsdae_record &now) { return now.step == 5 ? 1 : 0; });
  sim.observe([&](const nsdae_record &now) {
    seen++;
    if (now.step == 7) throw std::runtime_error("seven");
  });
  sim.init(0, {1}, {0});
  EXPECT(sim.run(1) == NSDAE_STOPPED && seen == 6); /* the start and five steps */
  EXPECT(throws<std::runtime_error>(
      [&] { sim.run(1); },
      [](const std::runtime_error &e) { return std::string(e.what()) == "seven"; }));
  EXPECT(seen == 8);
  for (int i = 2; i < NSDAE_OBSERVERS_MAX; i++) sim.observe([](const nsdae_record &) {});
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.observe([](const nsdae_record &) {}); }));
}

void test_interrupt()
{
  nsdae::sim sim(make_ball());
  int left = 3;
  sim.interrupt([&] { return left-- > 0 ? 0 : 1; });
  sim.init(0, {1}, {0});
  EXPECT(throws_status(NSDAE_E_INTERRUPTED, [&] { sim.run(1); }));
  EXPECT(sim.record().step == 3);
  left = 1000000;
  EXPECT(sim.run(1) == NSDAE_OK && sim.record().time == 1);
}

/* A callback that moves its own simulation is refused, with the text of that; one that replaces the
 * handle does not release the simulation under its call. */
void test_reentry()
{
  nsdae::system ball(make_ball());
  nsdae::sim *own = nullptr;
  int refused = 0;
  ball.force([&](double, const double *, const double *, double *F) {
    F[0] = -1;
    if (!own) return;
    refused += own->try_step() == NSDAE_E_STATE;
    refused += throws<nsdae::error>([&] { own->run(1); },
                                    [](const nsdae::error &e) {
                                      return e.status() == NSDAE_E_STATE &&
                                             std::strcmp(e.record().where, "nsdae_sim_run") == 0;
                                    });
    refused += throws_status(NSDAE_E_STATE, [&] { own->record(); });
    own->try_create(ball);
    own = nullptr;
  });
  nsdae::sim sim(ball);
  sim.init(0, {1}, {0});
  EXPECT(sim.step() == NSDAE_OK && sim.record().step == 1);
  own = &sim;
  EXPECT(sim.try_step() == NSDAE_OK && refused == 3 && !own);
  EXPECT(throws_status(NSDAE_E_STATE, [&] { sim.record(); })); /* the new one has no state */
}

/* A state that is set elsewhere goes on with the same bytes. */
void test_state()
{
  nsdae::system ball(make_ball());
  nsdae::sim sim(ball), other(ball);
  sim.init(0, {1}, {0});
  for (int i = 0; i < 30; i++) sim.step();
  const std::vector<unsigned char> block = sim.state();
  other.set_state(block);
  EXPECT(other.state() == block);
  for (int i = 0; i < 200; i++) {
    sim.step();
    other.step();
  }
  EXPECT(other.state() == sim.state());
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] {
    other.set_state(std::vector<unsigned char>(block.begin(), block.end() - 1));
  }));
  EXPECT(other.state() == sim.state());
}

/* What a simulation takes between steps, of a ball that falls from 1 m: y = 1 - g t^2 / 2. */
void test_between()
{
  const double g = 9.81;
  nsdae::system ball(make_ball());
  nsdae::options options;
  nsdae::sim sim(ball, options.set("method", "moreau").set("dt", 0.01));
  std::vector<double> q, v;
  sim.init(0, {1}, {0});
  EXPECT(throws_status(NSDAE_E_STATE, [&] { sim.interpolate(0, q, v); }));
  sim.run(0.2);
  sim.interpolate(0.193, q, v);
  EXPECT(std::fabs(q[0] - (1 - g * 0.193 * 0.193 / 2)) < 1e-12 &&
         std::fabs(v[0] + g * 0.193) < 1e-12);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.interpolate(0.1, q, v); }));

  sim.set_options(options.set("dt", 0.04));
  sim.step();
  EXPECT(std::fabs(sim.record().duration - 0.04) < 1e-12 &&
         std::fabs(sim.record().time - 0.24) < 1e-12);
  EXPECT(throws<nsdae::error>(
      [&] { sim.set_options(nsdae::options().set("method", "implicit").set("dt", 0.04)); },
      [](const nsdae::error &e) { return std::strcmp(e.record().argument, "method") == 0; }));
  sim.set_options(options.set("dt", 0.01));

  EXPECT(sim.run_to_event(3) == NSDAE_EVENT && sim.record().impacts == 1);
  EXPECT(std::fabs(sim.record().time - std::sqrt(2 / g)) < 0.02 && sim.record().v[0] > 2);
  sim.set_contact(0, 0, 0); /* from here on without rebound */
  EXPECT(sim.run_to_event(3) == NSDAE_EVENT && std::fabs(sim.record().v[0]) < 1e-12);
  EXPECT(sim.try_run_to_event(-1) == NSDAE_E_ARGUMENT);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.set_contact(1, 0, 0); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.set_contact(0, 1, 0); })); /* nt = 0 */
}

/* A block of 10 N in a slot, drawn with 5 N: v' = 5 - 10 mu. */
void test_slide()
{
  nsdae_dims dims = sizes(2, 1, 0);
  dims.f = 1;
  nsdae::system slot(dims);
  slot.mass([](double, const double *, double *M, int ldm) { M[0] = M[ldm + 1] = 1; });
  slot.force([](double, const double *, const double *, double *F) {
    F[0] = 5;
    F[1] = -10;
  });
  slot.constraint([](double, const double *q, double *phi) { phi[0] = q[1]; });
  slot.frictional_joint_tangent([](double, const double *, double *W, int, double *) { W[0] = 1; });
  slot.frictional_joint(0, 0, 0.2).friction_bound(0, 0).friction_circle(0, 0, 1, 0);
  nsdae::sim sim(slot, nsdae::options().set("method", "moreau").set("dt", 0.01));
  sim.init(0, {0, 0}, {0, 0});
  sim.run(0.1);
  EXPECT(std::fabs(sim.record().v[0] - 0.3) < 1e-9);
  sim.set_frictional_joint(0, 0.4);
  sim.run(0.2);
  EXPECT(std::fabs(sim.record().v[0] - 0.4) < 1e-9);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.set_frictional_joint(1, 0.4); }));
  sim.set_friction_bound(0, 2); /* v' = 5 - 4 - 2 */
  sim.run(0.3);
  EXPECT(std::fabs(sim.record().v[0] - 0.3) < 1e-9);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.set_friction_bound(0, -1); }));
}

/* A brake that closes: v = v_0 - t^2 / 2. */
void test_brake()
{
  nsdae_dims dims = sizes(1, 0, 0);
  dims.f = 1;
  nsdae::system disc(dims);
  disc.mass([](double, const double *, double *M, int) { M[0] = 2; });
  disc.force([](double, const double *, const double *, double *) {});
  disc.frictional_joint_tangent([](double, const double *, double *W, int, double *) { W[0] = 1; });
  disc.joint_friction_bound(
      [](double t, const double *, const double *, double *bound) { bound[0] = 2 * t; });
  nsdae::sim sim(disc, nsdae::options().set("method", "implicit").set("dt", 0.01));
  sim.init(0, {0}, {2});
  sim.run(1);
  EXPECT(std::fabs(sim.record().v[0] - 1.5) < 1e-12);
  sim.run(3);
  EXPECT(sim.record().v[0] == 0);
}

/* A start below the floor is put onto it. */
void test_project()
{
  nsdae::sim sim(make_ball());
  std::vector<double> q(1, -0.3), v(1, 1.0), wrong(2);
  sim.project(0, q, v);
  EXPECT(std::fabs(q[0]) < 1e-9 && std::fabs(v[0] - 1) < 1e-9);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.project(0, wrong, v); }));
}

/* A code of its own: > 0 and < 0 both end the run here, and nothing is thrown but error. */
void test_codes()
{
  for (int code = -3; code <= 3; code += 6) {
    nsdae::system ball(make_ball());
    ball.gap([code](double t, const double *q, double *g) {
      g[0] = q[0];
      return t > 0.1 ? code : 0;
    });
    nsdae::sim sim(ball);
    sim.init(0, {1}, {0});
    EXPECT(throws<nsdae::error>([&] { sim.run(1); },
                                [=](const nsdae::error &e) {
                                  return e.status() == NSDAE_E_CALLBACK && e.record().code == code;
                                }));
  }
}

static_assert(!std::is_copy_constructible<nsdae::system>::value, "owns");
static_assert(!std::is_copy_constructible<nsdae::sim>::value, "owns");
static_assert(!std::is_copy_assignable<nsdae::trajectory>::value, "owns");
static_assert(std::is_nothrow_move_constructible<nsdae::system>::value, "moves");
static_assert(std::is_nothrow_move_assignable<nsdae::sim>::value, "moves");
static_assert(std::is_nothrow_move_constructible<nsdae::trajectory>::value, "moves");

void test_moves()
{
  std::vector<nsdae::sim> sims;
  std::vector<double> end;
  {
    nsdae::system first = make_ball(), ball(std::move(first));
    EXPECT(!first && first.c() == nullptr && first.last_error()->status == NSDAE_E_ARGUMENT);
    EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { first.dims(); }));
    EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] {
      first.force([](double, const double *, const double *, double *) {});
    }));
    for (int i = 0; i < 3; i++) sims.push_back(nsdae::sim(ball)); /* they move as it grows */
    first = std::move(ball);
    EXPECT(first && !ball);
  } /* the system's handle is gone, the system is not */
  nsdae::sim moved(std::move(sims[0]));
  EXPECT(!sims[0] && sims[0].try_run(1) == NSDAE_E_ARGUMENT);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sims[0].observe([](const nsdae_record &) {}); }));
  sims[0] = std::move(moved);
  for (nsdae::sim &sim : sims) {
    sim.observe([&end](const nsdae_record &now) {
      if (now.step == 200) end.push_back(now.q[0]);
    });
    sim.init(0, {1}, {0});
    sim.run(1);
  }
  EXPECT(end.size() == 3 && end[0] == end[1] && end[1] == end[2]);
}

/* One system, two threads, each with its own simulation and its own exception. */
void test_threads()
{
  nsdae::system ball(make_ball());
  ball.force([](double t, const double *q, const double *, double *F) {
    F[0] = -1;
    if (t > 0.5) throw surprise{q[0] > 5 ? 10 : 1};
  });
  int got[2] = {0, 0};
  auto work = [&](int i, double height) {
    nsdae::sim sim(ball);
    sim.init(0, {height}, {0});
    throws<surprise>([&] { sim.run(1); }, [&](const surprise &s) { return got[i] = s.number; });
  };
  std::thread low(work, 0, 1.0), high(work, 1, 11.0);
  low.join();
  high.join();
  EXPECT(got[0] == 1 && got[1] == 10);
}

void test_trajectory(const char *path)
{
  try {
    nsdae::trajectory file;
    {
      nsdae::system ball = make_ball();
      nsdae_body floor = nsdae_body();
      floor.name = "floor";
      floor.shape = NSDAE_SHAPE_PLANE;
      floor.size[1] = 1;
      ball.add_body(floor);
      EXPECT(ball.bodies().size() == 1 && ball.bodies()[0].name == std::string("floor"));
      nsdae::sim sim(ball);
      file = nsdae::trajectory(sim, path, "ball");
      nsdae_body body = nsdae_body();
      body.name = "ball";
      body.shape = NSDAE_SHAPE_SPHERE;
      body.position[1] = "q1";
      EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { file.set_bodies({body}); }));
      body.size[0] = 0.1;
      EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { file.set_bodies({body}); }));
      body.position[1] = "q0";
      file.set_bodies({body});
      sim.init(0, {1}, {0});
      sim.run(0.1);
    } /* the file keeps it alive */
    file.put("/compare/exact", {1, 2, 3}, "m", "three numbers");
    nsdae::trajectory moved(std::move(file));
    EXPECT(moved && !file);
    moved.close();
    EXPECT(!moved && moved.try_close() == NSDAE_OK);
    nsdae::sim again(make_ball());
    nsdae_trajectory_info info = nsdae_trajectory_info();
    info.model = "ball";
    nsdae::trajectory resumed(nsdae::trajectory::resume(again, path, info));
    again.run(0.2);
    resumed.flush();
    resumed.close();
    info.contact_forces = 1; /* the file has none */
    EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { nsdae::trajectory::resume(again, path, info); }));
    info.contact_forces = 0;
    info.model = "bat";
    EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { nsdae::trajectory::resume(again, path, info); }));
    EXPECT(throws_status(NSDAE_E_IO, [] {
      nsdae::sim sim(make_ball());
      nsdae::trajectory(sim, "/no/such/folder/x.h5");
    }));
  } catch (const nsdae::error &e) {
    EXPECT(e.status() == NSDAE_E_UNSUPPORTED); /* built without HDF5 */
  }
  std::remove(path);
}

void test_check()
{
  nsdae::system rod(make_pendulum());
  rod.check(0, {0.1, 0.2, 0.3}, {1, 2, 3});
  rod.constraint_jacobian([](double, const double *q, double *J, int ldj) {
    J[0] = J[ldj + 1] = 1;
    J[2 * ldj] = -0.5 * std::cos(q[2]);
    J[2 * ldj + 1] = +0.5 * std::sin(q[2]); /* the sign is wrong */
  });
  EXPECT(rod.differences().find("gap_normal") != std::string::npos);
  EXPECT(throws_status(NSDAE_E_DERIVATIVE, [&] { rod.check(0, {0.1, 0.2, 0.3}, {1, 2, 3}); }));
  nsdae_check worst;
  const double q[] = {0.1, 0.2, 0.3};
  EXPECT(rod.try_check(0, q, q, 1e-5, &worst) == NSDAE_E_DERIVATIVE);
  EXPECT(worst.row == 1 && worst.column == 2);
  nsdae::system damped(make_pendulum());
  damped.force_damping([](double, const double *, const double *, double *D, int ldd) {
    D[2 * ldd] = 1; /* the force is constant */
  });
  damped.force_stiffness([](double, const double *, const double *, double *, int) {});
  EXPECT(damped.try_check(0, q, q, 1e-5, &worst) == NSDAE_E_DERIVATIVE);
  EXPECT(worst.row == 0 && worst.column == 2 && !std::strcmp(worst.term, "force_damping"));
}

/* Two balls on one another, by blocks and by list, with lambdas; what one throws comes out. */
void test_blocks()
{
  nsdae_dims dims = nsdae_dims();
  dims.nq = 2;
  bool spoil = false;
  nsdae::system system(dims);
  system.blocks({1, 1}, {1, 1})
      .mass_blocks([](double, const double *, double *M) { M[0] = 1, M[1] = 1000; })
      .force([](double, const double *, const double *, double *F) { F[0] = -10, F[1] = -1e4; })
      .contacts([&spoil](double, const double *q, const double *, double reach,
                         nsdae_contact_list *list) {
        if (spoil) throw std::runtime_error("no list");
        for (int i = 0; i < 2; i++) {
          nsdae_contact contact = nsdae_contact();
          contact.id = 10 + i;
          contact.block[0] = i;
          contact.block[1] = i - 1;
          contact.gap = i > 0 ? q[1] - q[0] - 1 : q[0];
          contact.direction[0][0][0] = 1;
          contact.direction[1][0][0] = -1;
          if (contact.gap <= reach) nsdae_contact_add(list, &contact);
        }
      });
  EXPECT(system.blocks() == 2);
  double rise = 0; /* of the force, which is constant */
  const auto blocks = [&rise](double, const double *, const double *, nsdae_block_list *list) {
    if (rise > 1) throw std::runtime_error("no block");
    nsdae_block_add(list, 1, 0, &rise);
  };
  system.force_damping_blocks(blocks).force_stiffness_blocks(blocks);
  system.check(0, {0.1, 1.2}, {0, 0});
  rise = 1;
  nsdae_check worst;
  const double q[] = {0.1, 1.2}, v[] = {0, 0};
  EXPECT(system.try_check(0, q, v, 1e-5, &worst) == NSDAE_E_DERIVATIVE);
  EXPECT(worst.row == 1 && worst.column == 0 && !std::strcmp(worst.term, "force_damping_blocks"));
  rise = 2;
  EXPECT(throws<std::runtime_error>(
      [&] {
        system.check(0, {0.1, 1.2}, {0, 0});
      },
      [](const std::runtime_error &e) { return !std::strcmp(e.what(), "no block"); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { system.blocks({1, 1}, {1}); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { system.blocks({1}, {1}); }));
  nsdae::sim sim(system, nsdae::options().set("method", "moreau").set("dt", "0.01"));
  sim.init(0, {0, 1}, {0, 0});
  for (int i = 0; i < 5; i++) sim.step();
  const nsdae_contact_set contacts = sim.record().contacts;
  EXPECT(contacts.count == 2 && contacts.id[1] == 11 && contacts.block[3] == 0);
  EXPECT(!sim.record().gap && !sim.record().normal_impulse && !sim.record().mode);
  EXPECT(std::fabs(contacts.normal_impulse[0] - 100.1) < 1e-9);
  EXPECT(std::fabs(contacts.normal_impulse[1] - 100) < 1e-9);
  spoil = true;
  EXPECT(throws<std::runtime_error>(
      [&] { sim.step(); },
      [](const std::runtime_error &e) { return !std::strcmp(e.what(), "no list"); }));
}

/* The same balls with fixed contacts, by every method that needs no SUNDIALS. */
void test_numbered_blocks()
{
  nsdae_dims dims = nsdae_dims();
  dims.nq = dims.k = 2;
  nsdae::system system(dims);
  system.blocks({1, 1}, {1, 1})
      .mass_blocks([](double, const double *, double *M) { M[0] = 1, M[1] = 1000; })
      .force([](double, const double *, const double *, double *F) { F[0] = -10, F[1] = -1e4; })
      .gap([](double, const double *q, double *g) { g[0] = q[0], g[1] = q[1] - q[0] - 1; });
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] {
    system.contacts([](double, const double *, const double *, double, nsdae_contact_list *) {});
  }));
  nsdae_system_clear_error(system.c());
  for (const char *method : {"implicit", "implicit-printed", "moreau"}) {
    nsdae::sim sim(system, nsdae::options().set("method", method).set("dt", "0.01"));
    sim.init(0, {0, 1}, {0, 0});
    for (int i = 0; i < 5; i++) sim.step();
    const nsdae_record record = sim.record();
    EXPECT(std::fabs(record.normal_impulse[0] - 100.1) < 1e-9);
    EXPECT(std::fabs(record.normal_impulse[1] - 100) < 1e-9);
    EXPECT(record.contacts.count == 2 && record.contacts.id[1] == 1);
    EXPECT(record.contacts.block[2] == -1 && record.contacts.block[3] == -1);
    EXPECT(record.contacts.gap == record.gap);
    EXPECT(record.contacts.normal_impulse == record.normal_impulse);
  }
}

/* A body in a slot: x, y are blocks, y = 0 carries the weight, and v = v_0 - mu g t along x. */
void test_joint_rows()
{
  nsdae_dims dims = nsdae_dims();
  dims.nq = 2;
  dims.m = dims.f = 1;
  nsdae::system system(dims);
  const double one = 1;
  system.blocks({1, 1}, {1, 1})
      .mass_blocks([](double, const double *, double *M) { M[0] = M[1] = 2; })
      .force([](double, const double *, const double *, double *F) { F[1] = -20; })
      .constraint([](double, const double *q, double *phi) { phi[0] = q[1]; })
      .constraint_rows(
          [&one](double, const double *, nsdae_row_list *rows) { nsdae_row_add(rows, 0, 1, &one); })
      .joint_friction_rows([&one](double, const double *, nsdae_row_list *rows, double *w_s) {
        w_s[0] = 0.5;
        nsdae_row_add(rows, 0, 0, &one);
      })
      .frictional_joint(0, 0, 0.25);
  nsdae::sim sim(system, nsdae::options().set("method", "moreau").set("dt", "0.01"));
  sim.init(0, {0, 0}, {1, 0});
  for (int i = 0; i < 20; i++) sim.step();
  EXPECT(std::fabs(sim.record().v[0] - 0.5) < 1e-12);
  for (int i = 0; i < 60; i++) sim.step(); /* until it moves with the slot */
  EXPECT(std::fabs(sim.record().v[0] + 0.5) < 1e-12);
}

} // namespace

/* A body of 2 kg hangs on a rope around a drum of 0.5 kg m^2 and 1 m that is written by hand: it
 * falls with 2 g / (2 + 0.5), and an exception of the drum comes out of the run. */
static void test_own()
{
  nsdae::bodies world(2);
  nsdae_rigid_body body = nsdae_rigid_body();
  body.mass = 2;
  body.inertia[2] = 1;
  world.gravity(0, -10);
  world.add(body);
  nsdae_dims dims = nsdae_dims();
  dims.nq = dims.m = 1;
  bool broken = false;
  nsdae::user_rows drum(dims);
  drum.mass([](double, const double *, double *M, int) { M[0] = 0.5; })
      .constraint([](double, const double *q, double *phi) { phi[0] = q[1] + q[3]; })
      .constraint_jacobian(
          [](double, const double *, double *J, int ldj) { J[ldj] = J[3 * ldj] = 1; })
      .constraint_bias(
          [&broken](double, const double *, const double *, double *phi_t, double *omega) {
            if (broken) throw std::runtime_error("broken");
            phi_t[0] = omega[0] = 0;
          });
  world.set_user_rows(drum);
  nsdae::system made = world.system();
  EXPECT(throws_status(NSDAE_E_STATE, [&] { world.set_user_rows(drum); }));
  drum = nsdae::user_rows(dims); /* the world has its own copy */
  nsdae::sim sim(made);
  sim.init(0, world.start().first, world.start().second);
  sim.run(1);
  EXPECT(std::fabs(sim.record().q[1] + 4) < 1e-12 && std::fabs(sim.record().q[3] - 4) < 1e-12);
  broken = true;
  bool thrown = false;
  try {
    sim.run(2);
  } catch (const std::runtime_error &e) {
    thrown = std::string(e.what()) == "broken";
  }
  EXPECT(thrown);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { nsdae::bodies(2).set_user_rows(drum); }));
}

/* The natural order of a builder: it returns a simulation, and its model and system are gone.
 * Free fall is exact by the default method: z = 1 - g/2 after 1 s. */
static void test_lifetimes()
{
  const auto build = [] {
    nsdae::bodies world(3);
    nsdae_rigid_body body = nsdae_rigid_body();
    body.mass = 1;
    body.position[2] = 1;
    for (double &J : body.inertia) J = 1;
    world.gravity(0, 0, -9.81).add(body);
    nsdae::sim sim(world.system());
    const auto start = world.start();
    sim.init(0, start.first, start.second);
    return sim;
  };
  nsdae::sim sim = build();
  sim.run(1);
  EXPECT(std::fabs(sim.record().q[2] + 3.905) < 1e-11);
}

/* A ball on a string against the ground, described by bodies: what C throws away comes as an
 * exception, what a load throws comes out of the run, and the system keeps its world. */
static void test_bodies()
{
  nsdae_rigid_body ball = nsdae_rigid_body();
  ball.mass = 2;
  ball.inertia[2] = 0.1;
  ball.position[1] = 1;
  const double centre[3] = {0, 1, 0};
  nsdae::system made;
  std::pair<std::vector<double>, std::vector<double>> start;
  bool refuse = false;
  {
    nsdae::bodies world(2);
    world.gravity(0, -10);
    EXPECT(world.add(ball) == 0);
    world.name(NSDAE_NAMED_BODY, 0, "ball");
    EXPECT(
        throws_status(NSDAE_E_ARGUMENT, [] { nsdae::bodies(2).name(NSDAE_NAMED_BODY, 0, "a"); }));
    EXPECT(nsdae::bodies(2).material("ice") == NSDAE_MATERIALS - 1);
    world.load(0, centre, [&](double, const double *, const double *, double *force, double *) {
      if (refuse) throw std::runtime_error("refused");
      force[1] = 20; /* carries its weight */
    });
    made = world.system();
    start = world.start();
    EXPECT(world.dims().nq == 3 && throws_status(NSDAE_E_STATE, [&] { world.add(ball); }));
  }
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [] { nsdae::bodies(4); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [] { nsdae::bodies().add(nsdae_rigid_body()); }));
  nsdae::sim sim(made);
  sim.init(0, start.first, start.second);
  sim.run(1);
  EXPECT(sim.record().q[1] == 1 && sim.record().v[1] == 0);
  refuse = true;
  bool thrown = false;
  try {
    sim.run(2);
  } catch (const std::runtime_error &e) {
    thrown = std::string(e.what()) == "refused";
  }
  EXPECT(thrown);
}

/* A surface of a mesh file. */
static void test_mesh()
{
  std::ofstream("handles.obj") << "v 0 0 0\nv 10 0 0\nv 0 10 0\nf 1 2 3\n";
  EXPECT(throws_status(NSDAE_E_IO, [] { nsdae::mesh("/no/such/file.stl"); }));
  nsdae::mesh read("handles.obj", 0.1), moved(std::move(read));
  EXPECT(read.c().points == 0 && moved.c().points == 3 && moved.c().point[3] == 1);
  moved->length[2] = 1;
  nsdae::bodies world(3);
  EXPECT(world.solid(NSDAE_GROUND, moved.c()) == 0);
}

/* A scene of a file, changed before it is a mechanism; its contact problems within contact_give and
 * within contact_work: set by the members of the struct and by text. */
static void test_scene()
{
  EXPECT(throws_status(NSDAE_E_IO, [] { nsdae::scene("/no/such/file.csv"); }));
  nsdae::scene read(NSDAE_DATA_DIR "/scene_mixed.csv"), moved(std::move(read));
  EXPECT(read.c().bodies == 0 && moved.c().bodies == 64);
  read = std::move(moved);
  read->body[0].velocity[0] = 1;
  nsdae::bodies world(3);
  world.add_scene(read);
  EXPECT(world.dims().nv == 6 * 64 && world.start().second[0] == 1);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { nsdae::bodies(2).add_scene(read); }));
  const nsdae::system system = world.system();
  const std::pair<std::vector<double>, std::vector<double>> start = world.start();

  nsdae::options options;
  options.set("method", "moreau").set("dt", "0.002").set("contact_tol", "1e-4");
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { options.set("contact_give", "0.5"); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { options.set("contact_work", "-1"); }));
  options.set("contact_work", "1").set("contact_give", "1e6");
  EXPECT(options->contact_work == 1 && options->contact_give == 1e6);
  nsdae::sim gives(system, options);
  gives.init(0, start.first, start.second);
  int status = gives.run(0.2);
  EXPECT(status == NSDAE_WARN_CONTACT || status == NSDAE_WARN_ENERGY);
  EXPECT(gives.stats().inexact_steps > 0 && gives.stats().worst_residual > 1e-4);
  options.set("contact_give", "1");
  nsdae::sim stops(system, options);
  stops.init(0, start.first, start.second);
  EXPECT(throws_status(NSDAE_E_LCP, [&] { stops.run(0.2); }));
  EXPECT(stops.stats().inexact_steps == 0);
  options.set("contact_work", "0");
  nsdae::sim works(system, options);
  works.init(0, start.first, start.second);
  EXPECT(works.run(0.2) >= 0 && works.stats().worst_residual <= 1e-4);
}

/* A driven joint: the crank turns as the function says. */
static void test_drive()
{
  nsdae::bodies world(2);
  nsdae_rigid_body crank = nsdae_rigid_body();
  crank.mass = crank.inertia[2] = 1;
  crank.position[0] = 1;
  crank.velocity[1] = 3;
  crank.spin[2] = 3;
  nsdae_joint pin = nsdae_joint();
  pin.kind = NSDAE_JOINT_REVOLUTE;
  pin.body[0] = NSDAE_GROUND;
  pin.body[1] = world.add(crank);
  world.joint(pin, [](double t, double *f) {
    f[0] = 3 * t;
    f[1] = 3;
    f[2] = 0;
  });
  nsdae::system made = world.system();
  nsdae::sim sim(made, nsdae::options().set("dt", 0.001));
  sim.init(0, world.start().first, world.start().second);
  sim.run(0.5);
  EXPECT(std::fabs(sim.record().q[2] - 1.5) < 1e-6);
  EXPECT(std::fabs(sim.record().q[0] - std::cos(1.5)) < 1e-5);
}

/* 2 kg on a spring of 18 N/m, 0.1 m too long, that turns against 4 N m/rad with its zero at 0.2. */
static void test_springs()
{
  nsdae::bodies world(2);
  nsdae_rigid_body body = nsdae_rigid_body();
  body.mass = 2;
  body.inertia[2] = 1;
  body.position[0] = 1.1;
  nsdae_spring spring = nsdae_spring();
  spring.body[0] = NSDAE_GROUND;
  spring.body[1] = world.add(body);
  spring.end[0] = 1.1;
  spring.stiffness = 18;
  spring.rest = 1;
  EXPECT(world.spring(spring) == 0);
  nsdae_torsion torsion = nsdae_torsion();
  torsion.body[0] = NSDAE_GROUND;
  torsion.stiffness = 4;
  torsion.rest = 0.2;
  EXPECT(world.torsion(torsion) == 0);
  nsdae::system made = world.system();
  nsdae::sim sim(made);
  sim.init(0, world.start().first, world.start().second);
  sim.run(1);
  EXPECT(std::fabs(sim.record().q[0] - 1 - 0.1 * std::cos(3)) < 1e-5);
  EXPECT(std::fabs(sim.record().q[2] - 0.2 * (1 - std::cos(2))) < 1e-5);
}

/* A rack of 2 kg on a pinion of 1 kg m^2 and radius 0.5 m, damped, with a stop; and a rope. */
static void test_couplers()
{
  nsdae::bodies world(2);
  nsdae_rigid_body body = nsdae_rigid_body();
  body.mass = 2;
  body.inertia[2] = 1;
  world.gravity(6, 0);
  nsdae_coupler coupler = nsdae_coupler();
  for (int i = 0; i < 2; i++) {
    nsdae_joint joint = nsdae_joint();
    joint.kind = i ? NSDAE_JOINT_PRISMATIC : NSDAE_JOINT_REVOLUTE;
    joint.body[0] = NSDAE_GROUND;
    joint.body[1] = world.add(body);
    joint.axis[0] = 1;
    coupler.joint[i] = world.joint(joint);
  }
  coupler.p[1] = 0.5;
  EXPECT(world.coupler(coupler) == 0);
  nsdae_limit limit = nsdae_limit();
  limit.joint = 1;
  limit.low = -1;
  limit.high = 0.2;
  EXPECT(world.limit(limit) == 0);
  nsdae_rope rope = nsdae_rope();
  rope.body[0] = NSDAE_GROUND;
  rope.body[1] = 1;
  rope.length = 3;
  EXPECT(world.rope(rope) == 2);
  world.set_colour(NSDAE_NAMED_BODY, 0, "#c23b22");
  nsdae_joint_spring damper = nsdae_joint_spring();
  damper.damping = 1e-6;
  EXPECT(world.joint_spring(damper) == 0);
  nsdae_motor motor = nsdae_motor();
  motor.joint = 1;
  motor.target = motor.limit = 12;
  EXPECT(world.motor(motor) == 0);
  motor.kind = NSDAE_MOTOR_SPEED; /* dry friction */
  motor.target = 0;
  const auto still = [](double, double *) { return 0; };
  const auto most = [](double, double *f) {
    f[0] = 12;
    return 0;
  };
  EXPECT(world.motor(motor, still, most) == 1);
  nsdae_sensor sensor = nsdae_sensor();
  sensor.joint = sensor.body = 1;
  EXPECT(world.sensor(sensor) == 0);
  sensor.kind = NSDAE_SENSOR_VELOCITY;
  EXPECT(world.sensor(sensor) == 1);
  nsdae::system made = world.system();
  nsdae::sim sim(made);
  sim.init(0, world.start().first, world.start().second);
  sim.run(0.2); /* 2 g / (2 + 1 / 0.25) = 2 */
  EXPECT(std::fabs(sim.record().q[3] - 0.04) < 1e-3);
  EXPECT(std::fabs(sim.record().q[3] - 0.5 * sim.record().q[2]) < 1e-5);
  sim.run(1);
  EXPECT(std::fabs(sim.record().q[3] - 0.2) < 1e-3);
  EXPECT(sim.control(0) == 12);
  EXPECT(std::fabs(sim.sensor(0)[0] - sim.record().q[3]) < 1e-14);
  EXPECT(sim.sensor(1).size() == 2 && sim.sensor(1)[0] == sim.record().v[3]);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.sensor(2); }));
  sim.set_control(0, -12); /* against the gravity: motor 1 brakes */
  EXPECT(sim.control(0) == -12);
  sim.run(1.5);
  EXPECT(std::fabs(sim.record().v[3]) < 1e-9);
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.set_control(1, 0); }));
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { sim.control(2); }));
}

/* A hull of its corners is a box: on its floor it rests; a flat one is refused by name. */
static void test_polyhedron()
{
  nsdae::bodies world(3);
  nsdae_solid floor = nsdae_solid(), hull = nsdae_solid();
  double corner[24];
  for (int i = 0; i < 24; i++) corner[i] = (i / 3 >> i % 3 & 1) + 3;
  floor.shape = NSDAE_SHAPE_PLANE;
  hull.shape = NSDAE_SHAPE_POLYHEDRON;
  hull.points = 8;
  hull.point = corner;
  nsdae_rigid_body body = nsdae_rigid_body();
  body.position[2] = -3;
  world.gravity(0, 0, -10);
  world.solid(NSDAE_GROUND, floor);
  EXPECT(world.add(body, {hull}, 2) == 0);
  world.pair(0, 0, 0.5, 0);
  nsdae::sim sim(world.system());
  sim.init(0, world.start().first, world.start().second);
  EXPECT(std::fabs(world.start().first[2] - 0.5) < 1e-14);
  sim.run(0.5);
  EXPECT(std::fabs(sim.record().q[2] - 0.5) < 1e-9);
  const auto pressed = sim.contact_forces(); /* 2 kg on corners */
  double weight = 0;
  EXPECT(pressed.first.size() == 12 && pressed.second.size() == 12);
  for (std::size_t i = 0; i < pressed.second.size(); i += 3) {
    weight += pressed.second[i + 2];
    EXPECT(pressed.second[i + 2] == 0 || std::fabs(std::fabs(pressed.first[i] - 3.5) - 0.5) < 1e-9);
  }
  EXPECT(std::fabs(weight - 20) < 1e-9);
  hull.points = 4;
  EXPECT(throws_status(NSDAE_E_ARGUMENT, [&] { nsdae::bodies(3).add(body, {hull}, 2); }));
}

/* Squares on a floor, one on the other, with contacts by number and by material: both rest. */
static void test_solids(bool by_material)
{
  const double corners[8] = {-0.5, -0.5, 0.5, -0.5, 0.5, 0.5, -0.5, 0.5};
  nsdae::bodies world(2);
  nsdae_solid floor = nsdae_solid(), square = nsdae_solid();
  nsdae_rigid_body body = nsdae_rigid_body();
  floor.shape = NSDAE_SHAPE_PLANE;
  square.shape = NSDAE_SHAPE_POLYGON;
  square.points = 4;
  square.point = corners;
  square.material = 1;
  EXPECT(nsdae_solid_inertia(&square, 3, &body.mass, body.inertia, nullptr) == NSDAE_OK);
  EXPECT(body.mass == 3 && std::fabs(body.inertia[2] - 0.5) < 1e-15);
  world.gravity(0, -10);
  int last = world.solid(NSDAE_GROUND, floor);
  for (int i = 0; i < 2; i++) {
    body.position[1] = 0.5 + i;
    int next = world.solid(world.add(body), square);
    if (!by_material) EXPECT(world.contact(last, next, 0.5, 0) >= 0);
    last = next;
  }
  if (by_material) world.pair(0, 1, 0.5, 0).pair(1, 1, 0.5, 0);
  nsdae::system made = world.system();
  nsdae::sim sim(made);
  sim.init(0, world.start().first, world.start().second);
  sim.run(0.1);
  for (int i = 0; i < 6; i++) EXPECT(std::fabs(sim.record().v[i]) < 1e-13);
  EXPECT(throws_status(NSDAE_E_STATE, [&] { world.pair(0, 1, 0, 0); }));
}

/* Two discs that a prismatic joint guides towards each other: they touch if the joint lets them. */
static void test_neighbours(bool collide)
{
  nsdae::bodies world(2);
  nsdae_solid disc = nsdae_solid();
  disc.shape = NSDAE_SHAPE_DISC;
  disc.radius = 0.25;
  nsdae_joint guide = nsdae_joint();
  guide.kind = NSDAE_JOINT_PRISMATIC;
  guide.axis[0] = 1;
  guide.collide_connected = collide;
  for (int i = 0; i < 2; i++) {
    nsdae_rigid_body body = nsdae_rigid_body();
    body.mass = body.inertia[2] = 1;
    body.position[0] = i ? 0.5 : -0.5;
    body.velocity[0] = i ? -1 : 1;
    guide.body[i] = world.add(body);
    world.solid(guide.body[i], disc);
  }
  EXPECT(world.pair(0, 0, 0, 0).joint(guide) == 0);
  nsdae::system made = world.system();
  nsdae::sim sim(made);
  sim.init(0, world.start().first, world.start().second);
  sim.run(1);
  EXPECT(std::fabs(sim.record().v[0] - (collide ? 0 : 1)) < 1e-12);
}

/* A rod on a free pin swings with the rate of a physical pendulum of small angle; where its end is.
 */
static void test_joint()
{
  nsdae::bodies world(2);
  nsdae_rigid_body rod = nsdae_rigid_body();
  rod.mass = 1;
  rod.inertia[2] = 1. / 12;
  rod.position[1] = -0.5;
  rod.spin[2] = 1e-3;
  rod.velocity[0] = 0.5e-3;
  nsdae_joint pin = nsdae_joint();
  pin.kind = NSDAE_JOINT_REVOLUTE;
  pin.body[0] = NSDAE_GROUND;
  pin.body[1] = world.add(rod);
  EXPECT(world.gravity(0, -10).joint(pin) == 0);
  nsdae::system made = world.system();
  nsdae::sim sim(made);
  sim.init(0, world.start().first, world.start().second);
  sim.run(1);
  const double rate = std::sqrt(15.0), end[3] = {0, -0.5, 0}; /* w^2 = m g L / 2 / (m L^2 / 3) */
  double angle = sim.record().q[2], point[3];
  EXPECT(std::fabs(angle - 1e-3 / rate * std::sin(rate)) < 1e-7);
  EXPECT(nsdae_bodies_locate(world.c(), sim.record().q, 0, end, point) == NSDAE_OK);
  EXPECT(std::fabs(point[0] - std::sin(angle)) < 1e-7 &&
         std::fabs(point[1] + std::cos(angle)) < 1e-7);
  EXPECT(nsdae_bodies_error(world.c())->status == NSDAE_OK);
}

int main(int argc, char **argv)
{
  test_same_bytes();
  test_errors();
  test_options();
  test_exceptions();
  test_observers();
  test_interrupt();
  test_reentry();
  test_state();
  test_between();
  test_slide();
  test_brake();
  test_project();
  test_codes();
  test_moves();
  test_threads();
  test_trajectory(argc > 1 ? argv[1] : "handles.h5");
  test_check();
  test_bodies();
  test_lifetimes();
  test_mesh();
  test_scene();
  test_springs();
  test_neighbours(false);
  test_neighbours(true);
  test_couplers();
  test_polyhedron();
  test_solids(false);
  test_solids(true);
  test_joint();
  test_own();
  test_drive();
  test_blocks();
  test_numbered_blocks();
  test_joint_rows();
  std::printf("%d failures\n", failures);
  return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
