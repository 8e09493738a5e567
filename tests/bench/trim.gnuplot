# Draws what trim_bench printed: gnuplot -e "csv='trim.csv'; svg='trim.svg'" trim.gnuplot
set terminal svg size 860,420 background rgb 'white' font 'sans-serif,12'
set output svg
set datafile separator ','
set multiplot layout 1,2
set logscale xy
set format y '%g'
set ylabel 'processor time [ms]'
set grid
set rmargin 4
set key left top
# Column 1: samples, 2: variables, 6: processor time.
rows(column, value) = sprintf("< awk -F, '$%d == %d' %s", column, value, csv)
set xlabel 'samples'
set xrange [150:140000]
set xtics ('200' 200, '1,000' 1000, '4,000' 4000, '20,000' 20000, '100,000' 100000)
plot for [n in '2 18 100 700'] rows(2, int(n)) using 1:6 with linespoints lw 2 title n.' variables', \
     4e-5 * x with lines dashtype 2 lc 'gray' title 'in proportion'
set xlabel 'variables'
unset ylabel
set xrange [1.5:1000]
set xtics ('2' 2, '18' 18, '100' 100, '700' 700)
plot for [n in '200 1000 4000 20000 100000'] rows(1, int(n)) using 2:6 with linespoints lw 2 title n.' samples', \
     2e-2 * x with lines dashtype 2 lc 'gray' title 'in proportion'
unset multiplot
