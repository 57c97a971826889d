% SPDX-License-Identifier: MIT
% Compiles the gateway into the folder of this file, or into `out`, against an installed library:
%   diffaqua_make (prefix, out)
% prefix: where it was installed; of a build folder that is not, give {include folder, library folder}.
function diffaqua_make (prefix, out)
  here = fileparts (mfilename ('fullpath'));
  if (nargin < 1)
    prefix = '/usr/local';
  end
  if (nargin < 2)
    out = here;
  end
  if (iscell (prefix))
    include = prefix{1};
    lib = prefix{2};
  else
    include = fullfile (prefix, 'include');
    lib = fullfile (prefix, 'lib');
  end
  found = dir (fullfile (here, 'src', '*.c'));
  sources = cellfun (@(name) fullfile (here, 'src', name), {found.name}, 'UniformOutput', false);
  target = fullfile (out, ['diffaqua_mex.' mexext()]);
  if (exist ('OCTAVE_VERSION', 'builtin'))
    flags = getenv ('CFLAGS');
    if (isempty (flags))
      setenv ('CFLAGS', '-O2 -fPIC');
    end
    [~, status] = mkoctfile ('--mex', '-o', target, ['-I' include], sources{:}, ['-L' lib], '-ldiffaqua', ...
                             ['-Wl,-rpath,' lib]);
    setenv ('CFLAGS', flags);
    if (status ~= 0)
      error ('diffaqua:make', 'the gateway was not compiled');
    end
  else
    mex ('-R2017b', '-outdir', out, '-output', 'diffaqua_mex', ['-I' include], sources{:}, ['-L' lib], '-ldiffaqua', ...
         ['LDFLAGS=$LDFLAGS -Wl,-rpath,' lib]);
  end
end
