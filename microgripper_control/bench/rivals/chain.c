/* The nominal chain by hand: the arithmetic of bouc_wen.py (n = 1) and second_order.py, in one loop.
 *
 * voltage[n], V, held from sample to sample; displacement[n], m, from rest. p holds d, alpha d,
 * beta, gamma; step the mechanics' difference equation for a sample period, as second_order.py
 * has it.
 */
#include <math.h>
#include <stddef.h>

static inline double grown(double c, double xi)
{
    double x = c * xi;
    if (fabs(x) < 0.2) {
        double y = x * x;
        return xi * (1.0 + y * (1.0 / 42))
             / (1.0 + x * (1.0 / 2) + y * (3.0 / 28 + x * (1.0 / 84) + y * (1.0 / 1680)));
    }
    return -expm1(-x) / c;
}

static inline double advance(double h, double du, double a, double beta, double gamma)
{
    double xi = fabs(du), feed = du > 0.0 ? a : -a, c, q;
    if (h * du < 0.0) {
        c = beta - gamma;
        q = grown(c, xi);
        double next = h * (1.0 - c * q) + feed * q;
        if (next * du <= 0.0)
            return next;
        xi -= fabs(c * h) < 1e-12 * a ? fabs(h) / a : log1p(c * fabs(h) / a) / c;
        h = 0.0;
    }
    c = beta + gamma;
    q = grown(c, xi);
    return h * (1.0 - c * q) + feed * q;
}

void chain(const double *p, const double *step, const double *voltage, double *displacement,
           size_t n)
{
    double u = 0.0, h = 0.0, x = 0.0, x_before = 0.0, w = 0.0, w_before = 0.0;
    for (size_t k = 0; k < n; k++) {
        displacement[k] = x;
        h = advance(h, voltage[k] - u, p[1], p[2], p[3]);
        u = voltage[k];
        double next = p[0] * u - h;
        double rest = step[1] * x_before + (step[2] * next + (step[3] * w + step[4] * w_before));
        x_before = x;
        x = step[0] * x + rest;
        w_before = w;
        w = next;
    }
}
