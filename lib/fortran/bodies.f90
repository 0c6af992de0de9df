! nsdae/bodies.h: rigid bodies, joints, forces and contacts between shapes, as a system.
!
! Bodies have a pose at the start. Joints, springs and contacts are given by points and axes in
! space at that time. Planar: q = [x, y, theta] of each body, v = q'. Spatial: q = [x, y, z,
! quaternion w, x, y, z], v = [x', y', z', angular velocity in body axes]. Bodies, solids, joints
! and contacts are numbered from 0, as in C; NSDAE_GROUND is the ground.
!
! Drives and loads are interoperable procedures (c_funloc) with a user pointer (c_loc).
module nsdae_f_bodies
  use, intrinsic :: iso_c_binding
  use nsdae_f_status
  use nsdae_f_system
  use nsdae_f_shape, only: NSDAE_SHAPE_POINT
  implicit none
  private

  integer(c_int), parameter, public :: NSDAE_GROUND = -1
  integer(c_int), parameter, public :: NSDAE_MATERIALS = 64  ! materials are 0 .. NSDAE_MATERIALS - 1

  integer(c_int), parameter, public :: &
      NSDAE_JOINT_REVOLUTE = 0, &
      NSDAE_JOINT_PRISMATIC = 1, &
      NSDAE_JOINT_WELD = 2, &
      NSDAE_JOINT_DISTANCE = 3, &
      NSDAE_JOINT_SLOT = 4, &
      NSDAE_JOINT_GEAR = 5, &
      NSDAE_JOINT_SPHERICAL = 6, &
      NSDAE_JOINT_CYLINDRICAL = 7, &
      NSDAE_JOINT_UNIVERSAL = 8

  ! A rigid body at the start.
  type, bind(C), public :: nsdae_rigid_body
    real(c_double) :: mass = 0           ! > 0 [kg]
    real(c_double) :: inertia(3) = 0     ! body axes, > 0 [kg m^2]; planar: the third only
    real(c_double) :: position(3) = 0    ! of the centre of mass [m]
    real(c_double) :: angle = 0          ! planar [rad]
    real(c_double) :: quaternion(4) = 0  ! spatial: w, x, y, z; all zero: no rotation
    real(c_double) :: velocity(3) = 0    ! of the centre of mass [m/s]
    real(c_double) :: spin(3) = 0        ! body axes [rad/s]; planar: the third only
  end type

  ! A solid of a body; the C header describes each shape in its frame.
  type, public :: nsdae_solid
    integer(c_int) :: shape = NSDAE_SHAPE_POINT
    real(c_double) :: radius = 0
    real(c_double) :: length(3) = 0
    logical :: hollow = .false.                    ! a disc with a hole
    real(c_double), allocatable :: point(:, :)     ! [2, corners] of a polygon, anticlockwise
    real(c_double) :: position(3) = 0, angle = 0   ! in the body's frame
    real(c_double) :: quaternion(4) = 0
    integer(c_int) :: material = 0                 ! for nsdae_bodies_set_pair
  end type

  ! The struct of the C header.
  type, bind(C), public :: nsdae_c_solid
    integer(c_int) :: shape = 0
    real(c_double) :: radius = 0
    real(c_double) :: length(3) = 0
    integer(c_int) :: hollow = 0
    integer(c_int) :: points = 0
    type(c_ptr) :: point = c_null_ptr
    real(c_double) :: position(3) = 0
    real(c_double) :: angle = 0
    real(c_double) :: quaternion(4) = 0
    integer(c_int) :: material = 0
  end type

  ! A joint; points and axes are in space at the start.
  type, bind(C), public :: nsdae_joint
    integer(c_int) :: kind = NSDAE_JOINT_REVOLUTE
    integer(c_int) :: body(2) = NSDAE_GROUND
    real(c_double) :: point(3) = 0
    real(c_double) :: end(3) = 0    ! DISTANCE: of the second body
    real(c_double) :: axis(3) = 0
    real(c_double) :: cross(3) = 0  ! UNIVERSAL
    real(c_double) :: ratio = 0     ! GEAR
    type(c_funptr) :: drive = c_null_funptr  ! a nsdae_drive_fn; null: free
    type(c_ptr) :: user = c_null_ptr
    real(c_double) :: mu = 0        ! SLOT
  end type

  ! A spring and damper between two points.
  type, bind(C), public :: nsdae_spring
    integer(c_int) :: body(2) = NSDAE_GROUND
    real(c_double) :: point(3) = 0, end(3) = 0
    real(c_double) :: stiffness = 0, damping = 0
    real(c_double) :: rest = 0  ! free length
  end type

  ! A rotational spring and damper about an axis.
  type, bind(C), public :: nsdae_torsion
    integer(c_int) :: body(2) = NSDAE_GROUND
    real(c_double) :: axis(3) = 0
    real(c_double) :: stiffness = 0, damping = 0
    real(c_double) :: rest = 0  ! angle of zero torque
  end type

  ! The user's own coordinates, constraints, contacts and frictional joints; the C header describes
  ! their order. Callbacks are interoperable procedures (c_funloc) with the arguments of
  ! nsdae/system.h; arrays have assumed size.
  type, bind(C), public :: nsdae_user_rows
    type(nsdae_dims) :: dims = nsdae_dims(0, 0, 0, 0, 0, 0)  ! of the user rows
    type(c_funptr) :: mass = c_null_funptr
    type(c_funptr) :: force = c_null_funptr
    type(c_funptr) :: constraint = c_null_funptr
    type(c_funptr) :: constraint_jacobian = c_null_funptr
    type(c_funptr) :: constraint_bias = c_null_funptr
    type(c_funptr) :: gap = c_null_funptr
    type(c_funptr) :: gap_normal = c_null_funptr
    type(c_funptr) :: gap_tangent = c_null_funptr
    type(c_funptr) :: contact_bias = c_null_funptr
    type(c_funptr) :: contact_acceleration = c_null_funptr
    type(c_funptr) :: frictional_joint_tangent = c_null_funptr
    type(c_funptr) :: kinematics = c_null_funptr
    type(c_funptr) :: constraint_rows = c_null_funptr
    type(c_funptr) :: contacts = c_null_funptr
    type(c_funptr) :: potential = c_null_funptr
    type(c_ptr) :: user = c_null_ptr
  end type

  ! A mechanism; empty before nsdae_bodies_create. Copies refer to the same mechanism.
  type, public :: nsdae_bodies
    private
    type(c_ptr) :: handle = c_null_ptr
  end type

  abstract interface
    ! drive := f(t), f'(t), f''(t)
    integer(c_int) function nsdae_drive_fn(t, drive, user) bind(C)
      import
      real(c_double), value :: t
      real(c_double), intent(inout) :: drive(3)
      type(c_ptr), value :: user
    end function
    ! Force and torque on a point of this position and velocity; both are zero on entry.
    integer(c_int) function nsdae_load_fn(t, position, velocity, force, torque, user) bind(C)
      import
      real(c_double), value :: t
      real(c_double), intent(in) :: position(3), velocity(3)
      real(c_double), intent(inout) :: force(3), torque(3)
      type(c_ptr), value :: user
    end function
  end interface

  public :: nsdae_drive_fn, nsdae_load_fn
  public :: nsdae_bodies_create, nsdae_bodies_destroy, nsdae_bodies_add, nsdae_bodies_add_joint, &
            nsdae_bodies_add_spring, nsdae_bodies_add_torsion, nsdae_bodies_add_load, &
            nsdae_bodies_add_solid, nsdae_bodies_add_contact, nsdae_bodies_set_pair, nsdae_bodies_set_gravity, &
            nsdae_bodies_set_user_rows, nsdae_bodies_system, nsdae_bodies_get_dims, nsdae_bodies_get_start, &
            nsdae_bodies_locate, nsdae_bodies_error, nsdae_solid_inertia

  interface
    integer(c_int) function c_create(dimension, bodies, error) bind(C, name='nsdae_bodies_create')
      import
      integer(c_int), value :: dimension
      type(c_ptr), intent(out) :: bodies
      type(nsdae_c_error), intent(inout) :: error
    end function
    subroutine c_destroy(bodies) bind(C, name='nsdae_bodies_destroy')
      import
      type(c_ptr), intent(inout) :: bodies
    end subroutine
    integer(c_int) function c_add(bodies, body) bind(C, name='nsdae_bodies_add')
      import
      type(c_ptr), value :: bodies
      type(nsdae_rigid_body), intent(in) :: body
    end function
    integer(c_int) function c_add_joint(bodies, joint) bind(C, name='nsdae_bodies_add_joint')
      import
      type(c_ptr), value :: bodies
      type(nsdae_joint), intent(in) :: joint
    end function
    integer(c_int) function c_add_spring(bodies, spring) bind(C, name='nsdae_bodies_add_spring')
      import
      type(c_ptr), value :: bodies
      type(nsdae_spring), intent(in) :: spring
    end function
    integer(c_int) function c_add_torsion(bodies, torsion) bind(C, name='nsdae_bodies_add_torsion')
      import
      type(c_ptr), value :: bodies
      type(nsdae_torsion), intent(in) :: torsion
    end function
    integer(c_int) function c_add_load(bodies, body, point, load, user) &
        bind(C, name='nsdae_bodies_add_load')
      import
      type(c_ptr), value :: bodies, user
      integer(c_int), value :: body
      real(c_double), intent(in) :: point(3)
      type(c_funptr), value :: load
    end function
    integer(c_int) function c_add_solid(bodies, body, solid) bind(C, name='nsdae_bodies_add_solid')
      import
      type(c_ptr), value :: bodies
      integer(c_int), value :: body
      type(nsdae_c_solid), intent(in) :: solid
    end function
    integer(c_int) function c_add_contact(bodies, solid0, solid1, mu, e_n, e_t) &
        bind(C, name='nsdae_bodies_add_contact')
      import
      type(c_ptr), value :: bodies
      integer(c_int), value :: solid0, solid1
      real(c_double), value :: mu, e_n, e_t
    end function
    integer(c_int) function c_set_pair(bodies, material0, material1, mu, e_n, e_t) &
        bind(C, name='nsdae_bodies_set_pair')
      import
      type(c_ptr), value :: bodies
      integer(c_int), value :: material0, material1
      real(c_double), value :: mu, e_n, e_t
    end function
    integer(c_int) function c_set_gravity(bodies, gravity) &
        bind(C, name='nsdae_bodies_set_gravity')
      import
      type(c_ptr), value :: bodies
      real(c_double), intent(in) :: gravity(3)
    end function
    integer(c_int) function c_set_own(bodies, own) bind(C, name='nsdae_bodies_set_user_rows')
      import
      type(c_ptr), value :: bodies
      type(nsdae_user_rows), intent(in) :: own
    end function
    integer(c_int) function c_system(bodies, system) bind(C, name='nsdae_bodies_system')
      import
      type(c_ptr), value :: bodies
      type(c_ptr), intent(inout) :: system
    end function
    integer(c_int) function c_get_dims(bodies, dims) bind(C, name='nsdae_bodies_get_dims')
      import
      type(c_ptr), value :: bodies
      type(nsdae_dims), intent(inout) :: dims
    end function
    integer(c_int) function c_get_start(bodies, q, v) bind(C, name='nsdae_bodies_get_start')
      import
      type(c_ptr), value :: bodies
      real(c_double), intent(inout) :: q(*), v(*)
    end function
    integer(c_int) function c_locate(bodies, q, body, local, point) &
        bind(C, name='nsdae_bodies_locate')
      import
      type(c_ptr), value :: bodies
      real(c_double), intent(in) :: q(*), local(3)
      integer(c_int), value :: body
      real(c_double), intent(inout) :: point(3)
    end function
    type(c_ptr) function c_error(bodies) bind(C, name='nsdae_bodies_error')
      import
      type(c_ptr), value :: bodies
    end function
    integer(c_int) function c_inertia(solid, density, mass, inertia, error) &
        bind(C, name='nsdae_solid_inertia')
      import
      type(nsdae_c_solid), intent(in) :: solid
      real(c_double), value :: density
      real(c_double), intent(inout) :: mass, inertia(3)
      type(nsdae_c_error), intent(inout) :: error
    end function
  end interface

contains

  ! Creates an empty model of dimension 2 or 3.
  integer(c_int) function nsdae_bodies_create(dimension, bodies, error) result(status)
    integer(c_int), intent(in) :: dimension
    type(nsdae_bodies), intent(out) :: bodies
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_create(dimension, bodies%handle, why)
    call error_from_c(why, error)
  end function

  ! Frees the model; destroy its system first.
  subroutine nsdae_bodies_destroy(bodies)
    type(nsdae_bodies), intent(inout) :: bodies
    call c_destroy(bodies%handle)
  end subroutine

  ! Each function adds one object and returns its number, or a status < 0. The first failure is
  ! stored: later calls and nsdae_bodies_system return it too.
  integer(c_int) function nsdae_bodies_add(bodies, body) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_rigid_body), intent(in) :: body
    number = c_add(bodies%handle, body)
  end function

  integer(c_int) function nsdae_bodies_add_joint(bodies, joint) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_joint), intent(in) :: joint
    number = c_add_joint(bodies%handle, joint)
  end function

  integer(c_int) function nsdae_bodies_add_spring(bodies, spring) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_spring), intent(in) :: spring
    number = c_add_spring(bodies%handle, spring)
  end function

  integer(c_int) function nsdae_bodies_add_torsion(bodies, torsion) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_torsion), intent(in) :: torsion
    number = c_add_torsion(bodies%handle, torsion)
  end function

  ! Adds a force callback on the point of a body, in space at the start.
  integer(c_int) function nsdae_bodies_add_load(bodies, body, point, load, user) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    integer(c_int), intent(in) :: body
    real(c_double), intent(in) :: point(3)
    procedure(nsdae_load_fn) :: load
    type(c_ptr), intent(in), optional :: user
    type(c_ptr) :: given
    given = c_null_ptr
    if (present(user)) given = user
    number = c_add_load(bodies%handle, body, point, c_funloc(load), given)
  end function

  integer(c_int) function nsdae_bodies_add_solid(bodies, body, solid) result(number)
    type(nsdae_bodies), intent(in) :: bodies
    integer(c_int), intent(in) :: body
    type(nsdae_solid), intent(in), target :: solid
    number = c_add_solid(bodies%handle, body, to_c(solid))
  end function

  ! Adds the contacts between two solids; returns the number of the first one, from 0.
  integer(c_int) function nsdae_bodies_add_contact(bodies, solid0, solid1, mu, e_n, e_t) &
      result(number)
    type(nsdae_bodies), intent(in) :: bodies
    integer(c_int), intent(in) :: solid0, solid1
    real(c_double), intent(in) :: mu, e_n, e_t
    number = c_add_contact(bodies%handle, solid0, solid1, mu, e_n, e_t)
  end function

  ! Enables contact between all solids of two materials that belong to different bodies. The system
  ! then uses a contact list.
  integer(c_int) function nsdae_bodies_set_pair(bodies, material0, material1, mu, e_n, e_t) &
      result(status)
    type(nsdae_bodies), intent(in) :: bodies
    integer(c_int), intent(in) :: material0, material1
    real(c_double), intent(in) :: mu, e_n, e_t
    status = c_set_pair(bodies%handle, material0, material1, mu, e_n, e_t)
  end function

  integer(c_int) function nsdae_bodies_set_gravity(bodies, gravity) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    real(c_double), intent(in) :: gravity(3)
    status = c_set_gravity(bodies%handle, gravity)
  end function

  ! Sets the user rows, once. NSDAE_E_ARGUMENT: the text names a callback that is missing or never
  ! called; NSDAE_E_STATE.
  integer(c_int) function nsdae_bodies_set_user_rows(bodies, own) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_user_rows), intent(in) :: own
    status = c_set_own(bodies%handle, own)
  end function

  ! Makes the system, or returns the first failure of any call before. bodies must outlive it.
  integer(c_int) function nsdae_bodies_system(bodies, system, error) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_system), intent(out) :: system
    type(nsdae_error), intent(out), optional :: error
    type(c_ptr) :: handle
    handle = c_null_ptr
    status = c_system(bodies%handle, handle)
    if (status < 0) then
      if (present(error)) error = nsdae_bodies_error(bodies)
    else
      status = system_of(handle, system, error)
    end if
  end function

  integer(c_int) function nsdae_bodies_get_dims(bodies, dims) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    type(nsdae_dims), intent(inout) :: dims
    status = c_get_dims(bodies%handle, dims)
  end function

  ! q [nq] and v [nv] at the start.
  integer(c_int) function nsdae_bodies_get_start(bodies, q, v) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    real(c_double), intent(inout), contiguous :: q(:), v(:)
    type(nsdae_dims) :: dims
    status = c_get_dims(bodies%handle, dims)
    if (status < 0) return
    status = NSDAE_E_ARGUMENT
    if (size(q) < dims%nq .or. size(v) < dims%nv) return
    status = c_get_start(bodies%handle, q, v)
  end function

  ! Position in space of the point local in body axes, at the coordinates q [nq].
  integer(c_int) function nsdae_bodies_locate(bodies, q, body, local, point) result(status)
    type(nsdae_bodies), intent(in) :: bodies
    real(c_double), intent(in), contiguous :: q(:)
    integer(c_int), intent(in) :: body
    real(c_double), intent(in) :: local(3)
    real(c_double), intent(inout) :: point(3)
    type(nsdae_dims) :: dims
    status = c_get_dims(bodies%handle, dims)
    if (status < 0) return
    status = NSDAE_E_ARGUMENT
    if (size(q) < dims%nq) return
    status = c_locate(bodies%handle, q, body, local, point)
  end function

  ! Error record of the first call that failed.
  type(nsdae_error) function nsdae_bodies_error(bodies) result(error)
    type(nsdae_bodies), intent(in) :: bodies
    error = error_at(c_error(bodies%handle))
  end function

  ! Mass and inertia of a solid of uniform density, in its frame.
  integer(c_int) function nsdae_solid_inertia(solid, density, mass, inertia, error) result(status)
    type(nsdae_solid), intent(in), target :: solid
    real(c_double), intent(in) :: density
    real(c_double), intent(inout) :: mass, inertia(3)
    type(nsdae_error), intent(out), optional :: error
    type(nsdae_c_error) :: why
    status = c_inertia(to_c(solid), density, mass, inertia, why)
    call error_from_c(why, error)
  end function

  ! The corners stay where they are.
  type(nsdae_c_solid) function to_c(solid) result(to)
    type(nsdae_solid), intent(in), target :: solid
    to%shape = solid%shape
    to%radius = solid%radius
    to%length = solid%length
    if (solid%hollow) to%hollow = 1
    if (allocated(solid%point)) then
      if (size(solid%point, 1) == 2) then
        to%points = size(solid%point, 2, kind=c_int)
        to%point = c_loc(solid%point)
      end if
    end if
    to%position = solid%position
    to%angle = solid%angle
    to%quaternion = solid%quaternion
    to%material = solid%material
  end function

end module
