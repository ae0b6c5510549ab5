# Reference correlation curves by spatstat for five generated patterns.
# Usage: Rscript pcf_reference.R > pcf_reference.json      (Debian package r-cran-spatstat)
#
# The kernel is exp(-x^2/s^2)/(sqrt(pi) s) with s = 0.25 r_max, a Gaussian of standard deviation
# s/sqrt(2); r_max = 2 sqrt(A/(2 sqrt(3) n)), n the count of the class that looks around.
suppressMessages(library(spatstat))
set.seed(20260101)

rectangle <- function(w, h) owin(c(0, w), c(0, h))
hexagonal <- function(win, spacing) {
  rows <- seq(win$yrange[1] + spacing / 3, win$yrange[2], by = spacing * sqrt(3) / 2)
  places <- do.call(rbind, lapply(seq_along(rows), function(k)
    cbind(seq(win$xrange[1] + spacing / 4 + (k %% 2) * spacing / 2, win$xrange[2], by = spacing), rows[k])))
  ppp(places[, 1], places[, 2], window = win)
}

patterns <- list(
  poisson  = rpoispp(150, win = rectangle(1, 1)),
  thomas   = rThomas(20, 0.04, 12, win = rectangle(1.5, 1)),
  hardcore = rSSI(0.05, 140, win = rectangle(1, 1)),
  lattice  = hexagonal(rectangle(10, 7), 0.7)
)
parents <- rpoispp(40, win = rectangle(2, 1))
children <- rThomas(20, 0.05, 5, win = rectangle(2, 1))
near <- ppp(pmin(pmax(parents$x + 0.05, 0), 2), parents$y, window = rectangle(2, 1))
two <- superimpose(a = parents, b = superimpose(children, near))

r_max <- function(x) 2 * sqrt(area(Window(x)) / (2 * sqrt(3) * npoints(x)))
number <- function(v, digits) paste(formatC(v, digits = digits, format = "g"), collapse = ",")
places <- function(x) paste0('"x":[', number(x$x, 12), '],"y":[', number(x$y, 12), ']')
curve <- function(x, f) {
  rm <- r_max(x)
  r <- c(0, seq(0.1, 5, by = 0.1) * rm)
  g <- f(r, 0.25 * rm / sqrt(2))$iso[-1]
  paste0('"r_max":', number(rm, 12), ',"g":[', number(g, 10), ']')
}
window <- function(x) paste0('"window":[', number(c(Window(x)$xrange[1], Window(x)$yrange[1],
                                                   Window(x)$xrange[2], Window(x)$yrange[2]), 12), ']')
one <- function(name) {
  x <- patterns[[name]]
  f <- function(r, bw) pcf(x, r = r, kernel = "gaussian", bw = bw, correction = "iso", divisor = "r")
  paste0('"', name, '":{', window(x), ',', places(x), ',', curve(x, f), '}')
}
cross <- function() {
  a <- split(two)$a
  b <- split(two)$b
  f <- function(r, bw) pcfcross(two, "b", "a", r = r, kernel = "gaussian", bw = bw,
                                correction = "iso", divisor = "r")
  paste0('"two_class":{', window(two), ',"parents":{', places(a), '},', places(b), ',', curve(b, f), '}')
}
cat("{", paste(c(sapply(names(patterns), one), cross()), collapse = ",\n"), "}\n", sep = "")
