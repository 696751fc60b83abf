"""Closed forms that the tests compare with, each written once, with its source; SI units.

An impact through linear springs and dashpots obeys d'' + gamma d' + omega0^2 d = 0, d(0) = 0,
d'(0) = v, with b = gamma/2 and w = sqrt(omega0^2 - b^2). Where n contacts act in parallel,
gamma and omega0^2 are n times those of one.
"""

import math

import numpy as np


def angular_frequency(kn, m, contacts=1):
    """omega0 [rad/s] of a reduced mass m [kg] on equal springs kn [N/m] in parallel."""
    return math.sqrt(contacts * kn / m)


def damped(omega0, gamma, t):
    """Displacement over initial velocity [s] and velocity over it [-] of a damped oscillator
    that starts in its middle: exp(-b t) sin(w t)/w (any textbook)."""
    b = gamma / 2
    w = math.sqrt(omega0**2 - b**2)
    decay = np.exp(-b * t)
    return decay * np.sin(w * t) / w, decay * (np.cos(w * t) - b / w * np.sin(w * t))


def restitution_at_zero_overlap(omega0, gamma):
    """e = exp(-pi b/w), wood-silo paper eq. 3.8: damped() at t = pi/w."""
    b = gamma / 2
    return math.exp(-math.pi * b / math.sqrt(omega0**2 - b**2))


def damping_of_restitution(omega0, e):
    """gamma [1/s] for which a contact that ends at zero overlap gives e."""
    return -2 * omega0 * math.log(e) / math.hypot(math.pi, math.log(e))


def contact_time(omega0, gamma):
    """pi/w [s] until the overlap is zero again."""
    return math.pi / math.sqrt(omega0**2 - (gamma / 2) ** 2)


def deepest_overlap(omega0, gamma, v):
    """Overlap [m] where d' = 0, at tan(w t) = w/b: (v/omega0) exp(-(b/w) atan(w/b))."""
    b = gamma / 2
    w = math.sqrt(omega0**2 - b**2)
    return v / omega0 * math.exp(-b / w * math.atan2(w, b))


# Harmonic motion of masses on springs (any textbook): (K + i w C - w^2 M) X = F.


def harmonic_motion(stiffness, mass, force, w, damping=0.0):
    """Complex amplitudes (n,) under forces F e^(i w t) (n,); matrices (n, n)."""
    return np.linalg.solve(stiffness + 1j * w * damping - w**2 * mass, force)


# Schwager and Poeschel 2007, Granular Matter 9, 465: restitution of a contact that ends at zero
# force, for the damping that would give the key where it ends at zero overlap.
ENDING_AT_ZERO_FORCE = {0.45: 0.511, 0.53: 0.574, 0.80: 0.808}

# A disc of radius r, I = m r^2/2, on a plane. Its contact point slows by (1/m + r^2/I) J = 3 J/m
# for a tangential impulse J, a sphere's by 7/2 (verification: Chung and Ooi 2011,
# 10.1007/s10035-011-0277-0, with 3 in place of 7/2).


def disc_after_gross_sliding(v_n, v_t, e, mu, r):
    """(v_t', spin) of a disc without spin that slides through all of its impact on a wall:
    the friction impulse is mu m (1 + e) v_n. Holds for v_t > 3 mu (1 + e) v_n."""
    return v_t - mu * (1 + e) * v_n, 2 * mu * (1 + e) * v_n / r


def disc_sliding_to_rolling(u0, mu, g):
    """(time, velocity) when a disc launched without spin rolls: u0/(3 mu g), 2 u0/3."""
    return u0 / (3 * mu * g), 2 * u0 / 3


def disc_rolling_down(angle, g):
    """Acceleration [m/s2] of a disc that rolls down, for mu > tan(angle)/3: (2/3) g sin."""
    return 2 / 3 * g * math.sin(angle)


def block_sliding_down(angle, mu, g):
    """Acceleration [m/s2] of a block that slides down, for tan(angle) > mu (Coulomb)."""
    return g * (math.sin(angle) - mu * math.cos(angle))


def block_creeping_down(angle, mu, g, gamma_t, contacts, t):
    """Velocity [m/s] of a block from rest, held back by tangential dashpots as well:
    v0 (1 - exp(-n gamma_t t)), v0 = g (sin - mu cos)/(n gamma_t); the wood-silo paper's
    eq. 3.11 with n vertex-edge pairs."""
    rate = contacts * gamma_t
    return block_sliding_down(angle, mu, g) / rate * -math.expm1(-rate * t)


def bounce_height(h0, r, e, k):
    """Centre height [m] after bounce k of a stiff ball dropped from h0 (MFiX DEM02)."""
    return (h0 - r) * e ** (2 * k) + r


def janssen(z, rho_g, mu, K, width):
    """Vertical stress [N/m] at depth z between two walls `width` apart: a slice of thickness dz
    weighs rho_g width dz, is pressed by K sigma from each wall and held by mu times that, so
    d sigma/dz = rho_g - (2 mu K/width) sigma, sigma(0) = 0 (Janssen 1895, in the plane)."""
    if mu * K == 0:
        return rho_g * z
    length = width / (2 * mu * K)
    return rho_g * length * (1 - np.exp(-z / length))


def gaussian_on_segment(dx, dy, bx, by, w):
    """int_0^1 phi(d - s b) ds, phi the Gaussian of the plane of width w: along b a difference of
    error functions, across it a Gaussian of the line."""
    length = math.hypot(bx, by)
    along, across = (dx * bx + dy * by) / length, (dx * by - dy * bx) / length
    part = math.erf(along / (w * math.sqrt(2))) - math.erf((along - length) / (w * math.sqrt(2)))
    return math.exp(-0.5 * (across / w) ** 2) / (math.sqrt(2 * math.pi) * w) * part / (2 * length)


# Impacts of spheres. Chung and Ooi 2011, Granular Matter 13, 643, 10.1007/s10035-011-0277-0.


def hertz_impact(modulus, radius, mass, speed):
    """(deepest overlap [m], largest force [N], contact time [s]) of an elastic impact; reduced
    quantities. With K = 4/3 E sqrt(R): (5 m v^2/(4 K))^0.4, K d^1.5, 2.9433 d/v (Hertz)."""
    k = 4 / 3 * modulus * math.sqrt(radius)
    overlap = (5 * mass * speed**2 / (4 * k)) ** 0.4
    return overlap, k * overlap**1.5, 2.9433 * overlap / speed


def damped_hertz_deepest(elastic, e):
    """Deepest overlap with Tsuji's dashpot over the elastic one: z = d^(5/4) is a linear damped
    oscillator of damping ratio b (Antypov and Elliott 2011, EPL 94, 50004), and its deepest point
    over the undamped one is exp(-(b/w) atan(w/b)), w = sqrt(1 - b^2)."""
    b = -math.log(e) / math.hypot(math.log(e), math.pi)
    w = math.sqrt(1 - b**2)
    return elastic * math.exp(-b / w * math.atan2(w, b)) ** 0.8


# Restitution of Hertz with Tsuji's dashpot that ends at zero force, for the damping that would
# give the key where it ends at zero overlap; to the third digit (verification; by Runge-Kutta).
HERTZ_ENDING_AT_ZERO_FORCE = {0.2: 0.325, 0.5: 0.550, 0.7: 0.718, 0.86: 0.864, 0.9: 0.902}


def sphere_after_gross_sliding(v_n, v_t, e, mu, r):
    """(v_t', spin, angle [rad] of the contact point) of a sphere that slides through all of its
    impact on a wall; the friction impulse is mu m (1 + e) v_n. For v_t > 3.5 mu (1 + e) v_n."""
    lost = mu * (1 + e) * v_n
    return v_t - lost, 2.5 * lost / r, math.atan2(v_t - 3.5 * lost, e * v_n)


# Alumina, 3.9 m/s, e 0.98, mu 0.092, by those formulas: angle [deg] -> e_t, spin [rad/s], rebound
# angle of the contact point [deg].
ALUMINA_OBLIQUE = {
    40: (0.7829, 544.2, 11.62),
    50: (0.8471, 456.7, 29.49),
    60: (0.8948, 355.2, 48.16),
    70: (0.9337, 243.0, 65.09),
    80: (0.9679, 123.4, 78.98),
}


def mindlin_ratio(nu):
    """Tangential over normal stiffness of two bodies of one material: 2 (1 - nu)/(2 - nu)
    (Mindlin 1949)."""
    return 2 * (1 - nu) / (2 - nu)


def students_t(freedom, p=0.975):
    """Quantile of Student's t of one or two degrees of freedom; Abramowitz and Stegun 26.7.3-4."""
    if freedom == 1:
        return math.tan(math.pi * (p - 0.5))
    assert freedom == 2
    return (2 * p - 1) / math.sqrt(2 * p * (1 - p))


def wilson_interval(k, n, z=1.959963984540054):
    """Ends of Wilson's score interval of k of n (J. Am. Stat. Assoc. 22 (1927) 209)."""
    middle = (k + z**2 / 2) / (n + z**2)
    half = z / (n + z**2) * math.sqrt(k * (n - k) / n + z**2 / 4)
    return middle - half, middle + half


# Loads on silos. EN 1991-4:2006; Jenike, Bulletin 123 (1964); Nedderman 1992, Statics and
# Kinematics of Granular Materials.


def janssen_pressure(z, gamma, mu, K, area, perimeter):
    """Horizontal pressure [Pa] in a silo of any cross section; gamma A/(mu U) far down."""
    z_o = area / perimeter / (K * mu)
    return gamma * K * z_o * (1 - np.exp(-z / z_o))


def wedge_limit(delta, wall):
    """Half angle [deg] up to which a wedge flows in mass: Arnold, McLean and Roberts's fit (1982)
    to Jenike's chart, angles in degrees, for wall < delta - 3."""
    numerator = math.exp(3.75 * 1.01 ** ((delta - 30) / 10)) - wall
    return numerator / (0.725 * math.tan(math.radians(delta)) ** 0.2)


def rathole_factor(phi):
    """Jenike's G(phi) [-], a polynomial in degrees (Leung et al. 2019, J. Pharm. Sci. 108, 464)."""
    return -5.066 + 0.490 * phi - 0.0112 * phi**2 + 0.000108 * phi**3


def radial_field(delta, wall, half_angle):
    """Mean stress over gamma r [-] at the wall of a plane wedge in Jenike's radial stress field.

    sigma = gamma r s(theta), major stress at psi from the radius, S = sin delta; balance of forces,

        s (1 + S cos 2psi) + S sin 2psi s' + 2 s S cos 2psi (psi' + 1) = -cos theta
        s' (1 - S cos 2psi) + 2 s S sin 2psi psi' + 3 s S sin 2psi = sin theta

    from the axis, psi = 90 deg, to the wall, psi = 90 deg + (wall + asin(sin wall/S))/2: shooting.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    sine = math.sin(delta)
    at_wall = math.pi / 2 + 0.5 * (wall + math.asin(math.sin(wall) / sine))

    def rates(theta, state):
        s, psi = state
        cos, sin = sine * math.cos(2 * psi), sine * math.sin(2 * psi)
        matrix = [[sin, 2 * s * cos], [1 - cos, 2 * s * sin]]
        right = [-math.cos(theta) - s * (1 + cos) - 2 * s * cos, math.sin(theta) - 3 * s * sin]
        return np.linalg.solve(matrix, right)

    def beyond(theta, state):  # the field ends where psi goes on; what is sought lies before
        return state[1] - at_wall - 0.1

    beyond.terminal = True

    def field(start):
        begin = [start, math.pi / 2]
        return solve_ivp(rates, (0, half_angle), begin, rtol=1e-8, events=beyond).y[:, -1]

    low = 0.05  # psi rises the less, the larger the stress on the axis is
    while field(1.2 * low)[1] > at_wall:
        low *= 1.2
    start = brentq(lambda s: field(s)[1] - at_wall, low, 1.2 * low)
    return float(field(start)[0])
